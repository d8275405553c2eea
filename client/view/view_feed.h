// What a bus says of one camera and its server, handed to a view.
#pragma once

#include <string>

#include "bus/bus.h"
#include "client/view/picture.h"
#include "client/view/view_model.h"
#include "convert/feature_parts.h"
#include "wire/channel.h"

namespace eifmap {

// All that the pages show.
struct View {
  ViewModel model{ViewModel::Clock::now(), random_requester()};
  Picture picture;
};

class ViewFeed {
 public:
  using Clock = ViewModel::Clock;

  // Subscribes on the bus, which must outlive the feed, as must the view. `camera`: "" takes the
  // first that a server speaks of, and only that one. Throws std::invalid_argument on an invalid
  // camera name.
  ViewFeed(const std::string& camera, View& view, Bus& bus);
  ~ViewFeed();
  ViewFeed(const ViewFeed&) = delete;
  ViewFeed& operator=(const ViewFeed&) = delete;

  const std::string& camera() const { return camera_; }  // "" none yet

  // To be called now and then, 10 times a second or more: asks the server for what is missing of
  // the map.
  void tick();

  // Features and images are for the eye: the next ones are taken after this.
  static constexpr auto kPicturePeriod = std::chrono::milliseconds(80);
  // Where images and features both came, what is silent for so long has ended.
  static constexpr auto kPictureSilence = std::chrono::seconds(2);

 private:
  void receive_pose(Bytes bytes);
  void receive_map(Bytes bytes);
  void receive_status(Bytes bytes);
  void receive_calibration(Bytes bytes);
  void receive_features(Bytes bytes);
  void receive_image(Bytes bytes);
  void subscribe(std::string_view camera, ChannelKind kind, void (ViewFeed::*handler)(Bytes));
  void choose(const std::string& camera);

  std::string camera_;
  View& view_;
  Bus& bus_;
  bool server_has_camera_ = false;  // the server shown has spoken of this camera
  FeatureAssembler parts_;
  Clock::time_point features_shown_{}, image_shown_{};
};

}  // namespace eifmap
