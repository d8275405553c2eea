#include "client/view/view_model.h"

#include <gtest/gtest.h>

#include "client/view/page_copy.h"
#include "client/view/view_messages.h"

namespace eifmap {
namespace {

using namespace test;
using namespace std::chrono_literals;

const ViewModel::Clock::time_point kStart{};

class ViewModelTest : public testing::Test {
 protected:
  void take_map(const MapUpdate& update) {
    for (const map_part_t& part : publishing_.publish(update, 5)) model_.take(part, now_);
  }
  // What a page that was there from the start keeps.
  const PageCopy& page() {
    if (const std::string text = model_.take_increment(now_); !text.empty()) early_.apply(text);
    return early_;
  }
  PageCopy late_page() const {
    PageCopy late;
    late.apply(model_.snapshot());
    return late;
  }
  template <class Message>
  void take(const Message& message) {
    model_.take(message, now_);
  }

  ViewModel::Clock::time_point now_ = kStart;
  ViewModel model_{kStart};
  PageCopy early_;
  Publishing publishing_;
};

TEST_F(ViewModelTest, NothingNewIsNothing) {
  page();
  EXPECT_EQ(model_.take_increment(now_), "");
  take(pose(5, 1, 0));
  EXPECT_NE(model_.take_increment(now_), "");
  EXPECT_EQ(model_.take_increment(now_), "");
}

TEST_F(ViewModelTest, SaysPoseMapAndStateAsTheyCame) {
  auto message = pose(5, 1, 3);
  message.result.covariance_status = CovarianceStatus::kValid;
  message.result.covariance.diagonal() << 0.04, 0.01, 0.09, 1, 1, 1;
  take(message);
  auto map = update(1, 0);
  map.keyframes.push_back({7, 1000, {so3_exp({0, 0.5, 0}), {1, 2, 3}}});
  add_landmark(21, 7, 4, map);
  map.landmarks[0].covariance = Eigen::Matrix3d::Identity() / 300;
  take_map(map);
  const PageCopy& copy = page();
  const auto& said = copy.sections.at("pose");
  EXPECT_EQ(said.at("position").dump(), "[1.0,0.1,-1.5]");
  EXPECT_TRUE(said.at("current"));
  EXPECT_EQ(said.at("source"), "SCALE_FIT");
  // The longest axis is the z, 3 sigma of it 0.9.
  EXPECT_NEAR(std::abs(said.at("ellipsoid").at(2).get<double>()), 0.9, 1e-6);
  EXPECT_NEAR(said.at("sigmas").at(0).get<double>(), 0.3, 1e-9);
  EXPECT_NEAR(said.at("sigmas").at(2).get<double>(), 0.1, 1e-9);
  EXPECT_EQ(copy.sections.at("state").at("state"), "TRACKING");
  EXPECT_EQ(copy.sections.at("state").at("text"), "150 of 200 map features agree with the pose");
  EXPECT_EQ(copy.keyframes.at("7").dump(), "[1.0,2.0,3.0,0.96891,0.0,0.2474,0.0]");
  EXPECT_EQ(copy.landmarks.at("21").dump(), "[7,0.1,-0.2,4.0,-3,0.1]");
  EXPECT_EQ(copy.path.dump(), "[[1.0,0.1,-1.5,0]]");
}

TEST_F(ViewModelTest, ThePathFollowsTheMapIntoMetres) {
  take(pose(5, 1, 3));
  EXPECT_EQ(page().sections.at("map").at("scale"), "arbitrary");
  auto message = pose(5, 1, 3);
  message.result.scale = {ScaleStatus::kFixed, 10, 0.02};
  message.result.map_from_camera.translation *= 10;
  take(message);
  take(pose(5, 1, 3));  // a late one
  const std::string expected = R"([[10.0,1.0,-15.0,0],[10.0,1.0,-15.0,1],[10.0,1.0,-15.0,1]])";
  EXPECT_EQ(page().path.dump(), expected);
  EXPECT_EQ(late_page().path.dump(), expected);
  EXPECT_EQ(page().sections.at("map").at("scale"), "metric");
  EXPECT_EQ(page().sections.at("map").at("scale_sigma"), 0.02);
  EXPECT_EQ(page().sections.at("events").at(0).at("text"), "the map is in metres now");
  take(pose(5, 2, 3));
  EXPECT_EQ(page().sections.at("map").at("scale"), "arbitrary") << "of another map";
  EXPECT_EQ(page().path.dump(), "[[1.0,0.1,-1.5,0]]");
}

// Axes that are no coordinate's: 0.3 along (2, 2, 1) / 3, the others 0.1 and 0.05.
TEST_F(ViewModelTest, TheEllipsoidLiesAsTheCovarianceDoes) {
  Eigen::Matrix3d axes;
  axes << 2, -2, 1, 2, 1, -2, 1, 2, 2;
  axes /= 3;
  auto message = pose(5, 1, 3);
  message.result.covariance_status = CovarianceStatus::kValid;
  message.result.covariance.setIdentity();
  message.result.covariance.topLeftCorner<3, 3>() =
      axes * Eigen::Vector3d(0.09, 0.01, 0.0025).asDiagonal() * axes.transpose();
  take(message);
  const auto& ellipsoid = page().sections.at("pose").at("ellipsoid");
  const double lengths[] = {0.3, 0.1, 0.05};
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d said;
    for (int i = 0; i < 3; ++i)
      said[i] = ellipsoid.at(static_cast<std::size_t>(3 * axis + i)).get<double>();
    EXPECT_NEAR(std::abs(said.dot(axes.col(axis))), 3 * lengths[axis], 1e-6);
    EXPECT_NEAR(said.norm(), 3 * lengths[axis], 1e-6);
  }
}

TEST_F(ViewModelTest, UnknownCovariancesAreSaidToBeUnknown) {
  take(pose(5, 1, 3));
  auto map = update(1, 0);
  add_landmark(21, 7, 4, map);
  take_map(map);
  EXPECT_TRUE(page().sections.at("pose").at("ellipsoid").is_null());
  EXPECT_EQ(page().landmarks.at("21").back(), -1.0);
}

TEST_F(ViewModelTest, OnlyWhatChangedInTheMapIsSaid) {
  auto map = update(1, 0);
  for (int i = 0; i < 3; ++i) map.keyframes.push_back({i, 1000, {}});
  for (int i = 0; i < 6; ++i) add_landmark(i, 0, 4, map);
  take_map(map);
  EXPECT_EQ(page().landmarks.size(), 6u);
  // The first, one in the middle and the last go; one moves; one is new.
  map = update(1, 1);
  map.removed_landmarks = {0, 3, 5};
  add_landmark(4, 0, 8, map);
  add_landmark(9, 0, 4, map);
  map.keyframes.push_back({1, 1000, {so3_exp({0, 0.5, 0}), {1, 2, 3}}});
  take_map(map);
  const std::string text = model_.take_increment(now_);
  early_.apply(text);
  const auto increment = nlohmann::json::parse(text);
  EXPECT_EQ(increment.at("removed_landmarks").dump(), "[0,3,5]");
  EXPECT_EQ(increment.at("landmarks").size(), 2 * 7u);
  EXPECT_EQ(increment.at("keyframes").size(), 8u);
  // A whole map again, without one of the keyframes.
  map = update(1, 0);
  map.seq = 7;
  map.keyframes = {{0, 1000, {}}, {1, 1000, {}}};
  add_landmark(4, 0, 8, map);
  take_map(map);
  EXPECT_EQ(page().keyframes.size(), 2u);
  EXPECT_EQ(page().landmarks.size(), 1u);
  EXPECT_EQ(late_page(), page());
}

TEST_F(ViewModelTest, AMapThatIsBehindIsSaidAndAskedFor) {
  MapUpdate first = update(1, 0), second = update(1, 1);
  first.keyframes.push_back({0, 1000, {}});
  second.keyframes.push_back({1, 1000, {}});
  take_map(first);
  auto heard = pose(5, 1, 0);
  heard.result.map_seq = 2;
  take(heard);
  EXPECT_FALSE(page().sections.at("map").at("behind")) << "its parts are on their way";
  now_ += 900ms;
  const auto request = model_.ask(now_, 7);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->missing.size(), 1u);
  EXPECT_EQ(request->missing[0].seq, 2);
  now_ += 200ms;
  EXPECT_TRUE(page().sections.at("map").at("behind"));
  take_map(second);
  EXPECT_FALSE(page().sections.at("map").at("behind"));
  EXPECT_EQ(page().keyframes.size(), 2u);
  EXPECT_FALSE(model_.ask(now_ + 1h, 7));
}

TEST_F(ViewModelTest, RefusalsComeWithWordsNumbersAndAHint) {
  auto waiting = pose(5, 0, 0, TrackingState::kStarting);
  waiting.result.reason = Reason::kNoBaseline;
  take(waiting);
  const auto state = page().sections.at("state");
  EXPECT_EQ(state.at("state"), "STARTING");
  EXPECT_EQ(state.at("reason"), "NO_BASELINE");
  EXPECT_EQ(state.at("hint"), describe(Reason::kNoBaseline).hint);
  take(status(5, status_t::STATE_STARTING, Reason::kNoBaseline));
  EXPECT_EQ(page().sections.at("state").at("text"), "551 of 595 matches");
  take(waiting);
  EXPECT_EQ(page().sections.at("state").at("text"), "551 of 595 matches") << "its numbers stay";
  auto lost = pose(5, 1, 1, TrackingState::kLost);
  lost.result.reason = Reason::kNotRelocalized;
  take(lost);
  EXPECT_EQ(page().sections.at("state").at("text"), describe(Reason::kNotRelocalized).text);
}

TEST_F(ViewModelTest, APathIsNotJoinedOverALoss) {
  take(pose(5, 1, 0));
  take(pose(5, 1, 1));
  take(pose(5, 1, 2, TrackingState::kLost));
  EXPECT_FALSE(page().sections.at("pose").at("current"));
  take(pose(5, 1, 3));
  std::vector<int> joined;
  for (const auto& step : page().path) joined.push_back(step.at(3));
  EXPECT_EQ(joined, (std::vector<int>{0, 1, 0}));
  EXPECT_EQ(late_page(), page());
}

TEST_F(ViewModelTest, ANewMapStartsFromNothing) {
  take(pose(5, 1, 0));
  auto map = update(1, 0);
  map.keyframes.push_back({0, 1000, {}});
  add_landmark(1, 0, 4, map);
  take_map(map);
  EXPECT_EQ(page().landmarks.size(), 1u);
  take(pose(5, 2, 1));
  EXPECT_EQ(page().path.size(), 1u);
  EXPECT_TRUE(page().landmarks.empty());
  EXPECT_EQ(page().sections.at("events").back().at("text"), "a new map was begun: map 2");
  take_map(map);
  take(pose(5, 1, 2));
  EXPECT_EQ(page().path.size(), 1u) << "what is late of the old map is passed over";
  EXPECT_TRUE(page().keyframes.empty());
  EXPECT_EQ(late_page(), page());
}

TEST_F(ViewModelTest, AMapThatIsInUseAgainIsShown) {
  const auto in_map = [](std::int64_t map_id, std::int64_t map_epoch, int i) {
    PublishedPose message = pose(5, map_id, i);
    message.result.map_epoch = map_epoch;
    return message;
  };
  take(in_map(1, 0, 0));
  take(in_map(2, 1, 3));
  take(in_map(1, 0, 6));  // said before that
  EXPECT_EQ(page().path.dump(), "[[1.0,0.1,-1.5,0]]");
  take(in_map(1, 2, 6));
  take(in_map(2, 1, 3));  // the same
  EXPECT_EQ(page().path.dump(), "[[2.0,0.1,-3.0,0]]");
  EXPECT_NE(page().sections.at("events").dump().find("the camera is in map 1 again"),
            std::string::npos);
  auto late = update(2, 0);
  late.map_epoch = 1;
  late.keyframes.push_back({9, 1000, {}});
  take_map(late);
  auto again = update(1, 0);
  again.map_epoch = 2;
  again.seq = 2;
  again.keyframes.push_back({7, 1000, {}});
  take_map(again);
  EXPECT_TRUE(page().keyframes.contains("7"));
  EXPECT_FALSE(page().keyframes.contains("9"));
}

TEST_F(ViewModelTest, ARestartOfTheServerIsSaid) {
  take(status(5, status_t::STATE_TRACKING));
  for (int i = 0; i < 10; ++i) take(pose(5, 3, i));
  auto map = update(3, 0);
  map.keyframes.push_back({0, 1000, {}});
  take_map(map);
  EXPECT_EQ(page().path.size(), 10u);
  EXPECT_FALSE(page().sections.contains("events"));
  take(status(6, status_t::STATE_WAITING));
  EXPECT_EQ(page().sections.at("events").back().at("text"), "server restarted: a new map");
  EXPECT_TRUE(page().path.empty());
  EXPECT_TRUE(page().keyframes.empty());
  EXPECT_TRUE(page().sections.at("pose").is_null());
  EXPECT_EQ(page().sections.at("state").at("state"), "WAITING");
  // The old run's last words, and then the new one's first map, which is no event of its own.
  take(pose(5, 3, 11));
  take(status(5, status_t::STATE_STOPPING));
  EXPECT_EQ(page().sections.at("state").at("state"), "WAITING");
  take(pose(6, 1, 0));
  EXPECT_EQ(page().path.size(), 1u);
  EXPECT_EQ(page().sections.at("events").size(), 1u);
  EXPECT_EQ(late_page(), page());
}

TEST_F(ViewModelTest, SilenceIsCounted) {
  take(pose(5, 1, 0));
  EXPECT_EQ(page().sections.at("silence_s"), 0);
  now_ += 2900ms;
  EXPECT_EQ(page().sections.at("silence_s"), 0);
  now_ += 1200ms;
  EXPECT_EQ(page().sections.at("silence_s"), 4);
  EXPECT_TRUE(model_.server_is_gone(now_));
  EXPECT_EQ(page().sections.at("state").at("state"), "NO SERVER");
  EXPECT_EQ(late_page(), page());
  take(status(5, status_t::STATE_WAITING));
  EXPECT_EQ(page().sections.at("silence_s"), 0);
  EXPECT_FALSE(model_.server_is_gone(now_));
  take(status(5, status_t::STATE_STOPPING));
  EXPECT_TRUE(model_.server_is_gone(now_));
  now_ += 10s;
  EXPECT_EQ(page().sections.at("state").at("state"), "STOPPED");
}

TEST_F(ViewModelTest, ALongPathIsThinnedNotCut) {
  const auto max = static_cast<int>(ShownPath::kMaxSteps);
  for (int i = 0; i < max + 10; ++i) {
    take(pose(5, 1, i));
    if (i % 1000 == 0) page();
  }
  EXPECT_EQ(page().path.size(), ShownPath::kMaxSteps / 2 + 10);
  EXPECT_EQ(page().path.back().at(2), -0.5 * (max + 9));
  EXPECT_EQ(page().path.front().at(2), -0.5);
  EXPECT_EQ(late_page(), page());
}

TEST_F(ViewModelTest, TextsOfAnyBytesAreShown) {
  auto said = status(5, status_t::STATE_LOST, Reason::kScaleJump);
  said.message = "not UTF-8: \xff\xfe <b>";
  take(said);
  const std::string text = page().sections.at("state").at("text");
  EXPECT_TRUE(text.starts_with("not UTF-8: ")) << text;
}

}  // namespace
}  // namespace eifmap
