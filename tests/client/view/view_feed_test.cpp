#include "client/view/view_feed.h"

#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "bus/lcm_bus.h"
#include "client/view/page_copy.h"
#include "convert/feature_parts.h"
#include "messages/samples.h"

namespace eifmap {
namespace {

using test::PageCopy;

class ViewFeedTest : public testing::Test {
 protected:
  ViewFeedTest() : lcm_(std::make_shared<lcm::LCM>("memq://")), bus_(lcm_), sender_(lcm_) {}

  void listen(const std::string& camera) { feed_.emplace(camera, view_, bus_); }

  template <class Message>
  void send(const std::string& camera, ChannelKind kind, const Message& message) {
    sender_.publish(channel_name(camera, kind), encode(message));
    bus_.receive(std::chrono::milliseconds(50));
  }
  void send_pose(const std::string& camera, std::int64_t epoch) {
    auto pose = samples::published_pose();
    pose.origin = {epoch, camera};
    send(camera, ChannelKind::kPose, to_message(pose));
  }
  void send_status(const std::string& camera, std::int64_t epoch, std::int8_t state) {
    auto status = samples::status();
    status.camera = camera;
    status.server_epoch = epoch;
    status.state = state;
    send(camera.empty() ? std::string(kNoCamera) : camera, ChannelKind::kStatus, status);
  }
  const PageCopy& page() {
    const auto now = ViewModel::Clock::now() + later_;
    if (const std::string text = view_.model.take_increment(now); !text.empty()) page_.apply(text);
    return page_;
  }
  std::string state() { return page().sections.at("state").at("state"); }

  View view_;
  std::shared_ptr<lcm::LCM> lcm_;
  LcmBus bus_, sender_;
  std::optional<ViewFeed> feed_;
  PageCopy page_;
  std::chrono::seconds later_{0};
};

TEST_F(ViewFeedTest, TheFirstCameraThatAServerSpeaksOfIsShown) {
  listen("");
  auto features = samples::features();
  features.camera = "unmapped";
  send("unmapped", ChannelKind::kFeatures, to_message(features));
  EXPECT_FALSE(page().sections.contains("features"));
  send_pose("first", 5);
  send_pose("other", 5);
  EXPECT_EQ(feed_->camera(), "first");
  EXPECT_EQ(page().sections.at("camera"), "first");
  EXPECT_EQ(page().path.size(), 1u);
  features.camera = "first";
  send("first", ChannelKind::kFeatures, to_message(features));
  EXPECT_EQ(page().sections.at("features").at("points").size(), 3 * features.keypoints.size());
  EXPECT_EQ(page().sections.at("features").at("width"), 640);
}

TEST_F(ViewFeedTest, OrTheOneThatIsAskedFor) {
  listen("other");
  send_pose("first", 5);
  send_pose("other", 5);
  send_pose("other", 5);
  EXPECT_EQ(page().path.size(), 2u);
  EXPECT_THROW(ViewFeed("no such name", view_, bus_), std::invalid_argument);
}

TEST_F(ViewFeedTest, FeaturesThatComeInPartsAreShownWhole) {
  listen("cam0");
  auto features = samples::features(300);
  features.camera = "cam0";
  for (const auto& part : split_features(features, 1400))
    send("cam0", ChannelKind::kFeatures, part);
  EXPECT_EQ(page().sections.at("features").at("points").size(), 900u);
  EXPECT_EQ(page().sections.at("malformed"), 0);
}

TEST_F(ViewFeedTest, EveryPixelFormatIsShown) {
  listen("cam0");
  for (const auto format : {PixelFormat::kGray, PixelFormat::kGray16, PixelFormat::kBgr,
                            PixelFormat::kRgba, PixelFormat::kYuyv, PixelFormat::kI420}) {
    auto image = samples::image();
    image.format = format;
    image.row_stride = format_info(format).bytes_per_pixel * image.width;
    image.data.assign(static_cast<std::size_t>(2 * image.row_stride * image.height), 3);
    view_.picture.take(image);
    EXPECT_EQ(view_.picture.jpeg().substr(0, 2), "\xff\xd8") << format_info(format).name;
    view_.picture.clear();
  }
}

TEST_F(ViewFeedTest, ImagesBecomeAPicture) {
  constexpr int kImages = 50;
  listen("cam0");
  const auto image = to_message(samples::image());
  const auto begin = ViewFeed::Clock::now();
  send("cam0", ChannelKind::kImage, image);
  EXPECT_EQ(view_.picture.number(), 1);
  EXPECT_EQ(view_.picture.jpeg().substr(0, 2), "\xff\xd8");
  for (int i = 1; i < kImages; ++i) send("cam0", ChannelKind::kImage, image);
  // On a busy machine they may come slowly: so many as the time that it took allows.
  const auto periods = (ViewFeed::Clock::now() - begin) / ViewFeed::kPicturePeriod;
  EXPECT_LE(view_.picture.number(), 1 + periods) << "they come faster than anybody looks";
}

TEST_F(ViewFeedTest, TheCalibrationGivesTheFrustumItsShape) {
  listen("");
  send_status("cam0", 5, status_t::STATE_STARTING);
  auto camera = samples::camera();
  camera.name = "cam0";
  send("cam0", ChannelKind::kCalibration, to_message(camera));
  EXPECT_NEAR(page().sections.at("lens").at("half_width").get<double>(), 320 / 520.25, 1e-5);
}

TEST_F(ViewFeedTest, GarbageIsCounted) {
  listen("cam0");
  const std::vector<std::uint8_t> garbage(40, 0xee);
  for (const auto kind : {ChannelKind::kPose, ChannelKind::kMap, ChannelKind::kStatus,
                          ChannelKind::kCalibration, ChannelKind::kFeatures, ChannelKind::kImage}) {
    sender_.publish(channel_name("cam0", kind), garbage);
    bus_.receive(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(page().sections.at("malformed"), 6);
  EXPECT_EQ(state(), "NO SERVER");
}

TEST_F(ViewFeedTest, AServerWithoutACameraIsShownWhileThereIsNoOther) {
  listen("");
  send_status("", 5, status_t::STATE_WAITING);
  EXPECT_EQ(state(), "WAITING");
  send_pose("cam0", 5);
  send_status("", 6, status_t::STATE_WAITING);
  EXPECT_FALSE(page().sections.contains("events")) << "it is another server's, and of no camera";
  EXPECT_EQ(page().path.size(), 1u);
  send_status("cam0", 5, status_t::STATE_STOPPING);
  EXPECT_EQ(state(), "STOPPED");
  send_status("", 7, status_t::STATE_WAITING);
  EXPECT_EQ(state(), "WAITING");
  EXPECT_EQ(page().sections.at("events").back().at("text"), "server restarted: a new map");
}

}  // namespace
}  // namespace eifmap
