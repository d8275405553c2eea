// What commands do to one camera's mapping. In its mapping thread, between two frames.
#pragma once

#include <functional>
#include <vector>

#include "server/camera_mapper.h"
#include "server/command_target.h"
#include "server/map_publisher.h"
#include "server/status_board.h"
#include "wire/channel.h"

namespace eifmap {

class CameraCommands : public CommandTarget {
 public:
  using Send = std::function<void(ChannelKind kind, const std::vector<std::uint8_t>& bytes)>;

  // All must outlive it. `send`: on the camera's channels.
  CameraCommands(std::int64_t server_epoch, CameraMapper& mapper, MapPublisher& maps,
                 StatusBoard& board, Send send)
      : server_epoch_(server_epoch),
        mapper_(mapper),
        maps_(maps),
        board_(board),
        send_(std::move(send)) {}

  Place place() const override;
  CommandOutcome ping() override;
  CommandOutcome pause() override;
  CommandOutcome resume() override;
  CommandOutcome reset() override;
  CommandOutcome maps() override;
  CommandOutcome snapshot() override;
  CommandOutcome set_scale(double metres_per_unit, double sigma) override;
  CommandOutcome save(const std::string& name) override;
  CommandOutcome load(const std::string& name) override;
  CommandOutcome checkpoint() override;
  CommandOutcome undo() override;
  CommandOutcome localize_only(bool on) override;
  CommandOutcome shutdown() override;  // refused: of the whole server alone

 private:
  const std::int64_t server_epoch_;
  CameraMapper& mapper_;
  MapPublisher& maps_;
  StatusBoard& board_;
  const Send send_;
  std::int64_t snapshots_ = 0, scales_ = 0;  // said so far
};

}  // namespace eifmap
