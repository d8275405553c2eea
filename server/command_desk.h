// Where commands to one camera's mapping, or to a server as a whole, are checked, done once, and
// answered. Knows no network and no clock.
//
// Who may command: with a secret, who signs with it. Without one, who is on this machine, as far as
// LCM lets one know: the network must end here, so that nobody elsewhere hears a reply; and what a
// command must name, the run's epoch and a ticket, of which the first is drawn by chance, only a
// reply tells.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command/command_message.h"
#include "command/secret.h"
#include "server/command_target.h"
#include "server/request_memory.h"

namespace eifmap {

// Of a run of a server: what all of its desks have in common.
struct CommandAccess {
  using TimePoint = std::chrono::steady_clock::time_point;

  std::int64_t server_epoch = 0;  // above 0
  std::shared_ptr<const Secret> secret = nullptr;
  bool is_local = false;          // the network ends at this machine
  std::int64_t first_ticket = 1;  // at `begin`; random_ticket() where it must not be guessed
  TimePoint begin = {};

  std::int64_t ticket(TimePoint now) const {
    return first_ticket +
           std::chrono::duration_cast<std::chrono::microseconds>(now - begin).count();
  }
};

std::int64_t random_ticket();  // above 0, with room to grow

class CommandDesk {
 public:
  using TimePoint = CommandAccess::TimePoint;

  // A command that names an older ticket is refused.
  static constexpr auto kTicketHolds = std::chrono::seconds(60);

  // `camera`: the channel's; `target` must outlive the desk. Throws std::invalid_argument where the
  // name is none.
  CommandDesk(std::string camera, CommandAccess access, CommandTarget& target);

  // Of one message on the channel: the reply, encoded; nothing where the message cannot be read,
  // and so nobody can be told.
  std::optional<std::vector<std::uint8_t>> answer(Bytes bytes, TimePoint now);

  struct Counts {
    std::int64_t done = 0;  // also those that ended in an error
    std::int64_t pings = 0;
    std::int64_t repeated = 0;               // answered as before
    std::map<Reason, std::int64_t> refused;  // kMalformedMessage too
    std::string last;  // the command that was done last, and what came of it; "" none
  };
  const Counts& counts() const { return counts_; }

 private:
  CommandOutcome do_once(const command_t& command);
  CommandOutcome dispatch(const command_t& command);
  std::optional<CommandOutcome> denied(const command_t& command, bool& is_signed) const;
  std::string age_problem(const command_t& command, TimePoint now) const;
  std::vector<std::uint8_t> reply_to(const command_t& command, CommandOutcome outcome,
                                     bool is_signed, TimePoint now);

  const std::string camera_;
  const CommandAccess access_;
  CommandTarget& target_;
  RequestMemory memory_;
  Counts counts_;
};

}  // namespace eifmap
