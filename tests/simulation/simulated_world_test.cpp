#include "simulation/simulated_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace eifmap {
namespace {

// Bilinear; the caller keeps x in [0, cols - 1) and y in [0, rows - 1).
template <typename T>
double sample(const cv::Mat& image, double x, double y) {
  const int c = static_cast<int>(x), r = static_cast<int>(y);
  const double u = x - c, v = y - r;
  return (1 - v) * ((1 - u) * image.at<T>(r, c) + u * image.at<T>(r, c + 1)) +
         v * ((1 - u) * image.at<T>(r + 1, c) + u * image.at<T>(r + 1, c + 1));
}

bool inside(const cv::Mat& image, const Eigen::Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < image.cols - 1.001 && p.y() < image.rows - 1.001;
}

Eigen::Vector3d point_of(const Camera& camera, const cv::Mat& depth, int column, int row) {
  const Eigen::Vector2d n = camera.normalized_from_pixel({column, row});
  return depth.at<float>(row, column) * Eigen::Vector3d(n.x(), n.y(), 1);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

struct Difference {
  double median = 0, share = 0;  // gray levels; share of the pixels that both images see
};

// Every third pixel of image a, taken by its depth and the two poses to image b, has the same gray.
Difference warp_difference(const SimulatedWorld& world, int a, int b, const Rigid3& error) {
  const Camera& camera = world.camera();
  const cv::Mat image_a = world.render(a), image_b = world.render(b);
  const cv::Mat depth_a = world.depth(a), depth_b = world.depth(b);
  const Rigid3 b_from_a =
      (world.world_from_camera(b) * error).inverse() * world.world_from_camera(a);
  std::vector<double> differences;
  int pixels = 0;
  for (int row = 0; row < camera.height; row += 3)
    for (int column = 0; column < camera.width; column += 3, ++pixels) {
      const Eigen::Vector3d x = b_from_a * point_of(camera, depth_a, column, row);
      if (x.z() < 0.1) continue;
      const Eigen::Vector2d p = camera.pixel_from_normalized(x.head<2>() / x.z());
      if (!inside(image_b, p)) continue;
      if (std::abs(sample<float>(depth_b, p.x(), p.y()) / x.z() - 1) > 0.02) continue;  // hidden
      differences.push_back(std::abs(sample<std::uint8_t>(image_b, p.x(), p.y()) -
                                     image_a.at<std::uint8_t>(row, column)));
    }
  if (differences.empty()) return {255, 0};
  return {median(differences), static_cast<double>(differences.size()) / pixels};
}

// The truth is true: images agree through depth and pose, and no longer when a pose is wrong by a
// hundredth of the walk's step or a pixel's angle times three.
TEST(SimulatedWorld, ImagesAgreeThroughDepthAndPose) {
  SimulationOptions options;
  options.noise = 0;
  const SimulatedWorld world(options);
  const Rigid3 turned(so3_exp({0, 3 / 470.0, 0}), Eigen::Vector3d::Zero());
  for (int frame : {0, 57, 133, 208, 290, 371}) {
    const auto next = warp_difference(world, frame, frame + 1, {});
    EXPECT_LT(next.median, 1.6) << frame;
    EXPECT_GT(next.share, 0.8) << frame;
    EXPECT_LT(warp_difference(world, frame, frame + 5, {}).median, 3.0) << frame;
    EXPECT_GT(warp_difference(world, frame, frame + 1, turned).median, 2.5 * next.median) << frame;
  }
  // The lap is closed: the first place is seen again.
  EXPECT_GT(warp_difference(world, world.num_frames() - 20, 0, {}).share, 0.3);
}

// Also where the camera turns fast beside near things, and when it is rolled.
TEST(SimulatedWorld, ImagesAgreeInATurnAndRolled) {
  SimulationOptions options;
  options.noise = 0;
  options.motion = "turn";
  options.roll_deg = 60;
  const SimulatedWorld world(options);
  for (int frame : {30, 76, 80, 84, 90, 150}) {
    const auto next = warp_difference(world, frame, frame + 1, {});
    EXPECT_LT(next.median, 2.5) << frame;
    EXPECT_GT(next.share, 0.6) << frame;
  }
}

// Every world with what is done in it.
TEST(SimulatedWorld, ImagesAgreeInWhatIsHardToMap) {
  struct Way {
    const char *world, *motion;
    double speed;
  };
  for (const auto& [world_name, motion, speed] :
       {Way{"street", "drive", 4}, Way{"wall", "sideways", 0.5}, Way{"wall", "pan", 0},
        Way{"tiles", "lap", 0}}) {
    SimulationOptions options;
    options.world = world_name;
    options.motion = motion;
    options.speed = speed;
    options.noise = 0;
    const SimulatedWorld world(options);
    for (const int frame : {0, 130}) {
      const auto next = warp_difference(world, frame, frame + 1, {});
      EXPECT_LT(next.median, 2.5) << world_name << ' ' << motion << ' ' << frame;
      EXPECT_GT(next.share, 0.5) << world_name << ' ' << motion << ' ' << frame;
    }
  }
}

// Straight on, in turns, and a lap later the same again.
TEST(SimulatedWorld, ASecondLapRoundTheBlockSeesWhatTheFirstSaw) {
  SimulationOptions options;
  options.world = "block";
  options.num_frames = 600;
  options.noise = 0;
  const SimulatedWorld world(options);
  for (const int frame : {0, 60, 130, 290}) {
    const auto next = warp_difference(world, frame, frame + 1, {});
    EXPECT_LT(next.median, 2.5) << frame;
    EXPECT_GT(next.share, 0.6) << frame;
    const auto lap_later = warp_difference(world, frame, frame + 300, {});
    EXPECT_LT(lap_later.median, 2.5) << frame;
    EXPECT_GT(lap_later.share, 0.5) << frame;
  }
  EXPECT_LT(warp_difference(world, 0, 75, {}).share, 0.05) << "another street is another";
}

// Seen from 4.2 m farther on it is as if one had not moved.
TEST(SimulatedWorld, ACorridorIsTheSameAgainAndAgain) {
  SimulationOptions options;
  options.world = "corridor";
  options.motion = "walk";
  options.noise = 0;
  const SimulatedWorld world(options);
  const auto next = warp_difference(world, 0, 1, {});
  EXPECT_LT(next.median, 2.5);
  EXPECT_GT(next.share, 0.6);
  const Rigid3 pose = world.world_from_camera(60);
  const auto farther = [&pose](double metres) {
    return pose.inverse() * Rigid3({1, 0, 0, 0}, {0, 0, -metres}) * pose;
  };
  const auto period = warp_difference(world, 0, 60, farther(4.2));
  EXPECT_LT(period.median, 2.5);
  EXPECT_GT(period.share, 0.5);
  EXPECT_GT(warp_difference(world, 0, 60, farther(2.1)).median, 4 * period.median);
}

// In the dark, then where it has been before, and on from there.
TEST(SimulatedWorld, AKidnappedCameraIsElsewhereAfterTheDark) {
  SimulationOptions options;
  options.noise = 0;
  const SimulatedWorld plain(options);
  options.event = "kidnapped";
  options.event_from_s = 5;
  options.event_for_s = 1.5;
  options.event_to_s = 2;
  const SimulatedWorld world(options);
  const auto at = [](const SimulatedWorld& w, int frame) {
    return w.world_from_camera(frame).translation;
  };
  EXPECT_EQ(at(world, 99), at(plain, 99));
  EXPECT_EQ(at(world, 100), at(plain, 40));
  EXPECT_EQ(at(world, 129), at(plain, 40));
  EXPECT_NEAR((at(world, 145) - at(plain, 55)).norm(), 0, 1e-9);
  cv::Scalar dark = cv::mean(world.render(129));
  EXPECT_LT(dark[0], 10);
  cv::Mat difference;
  cv::absdiff(world.render(130), plain.render(40), difference);
  EXPECT_EQ(cv::countNonZero(difference), 0);
}

// The share of pixels that differ between two worlds at a frame, noise aside.
double changed_share(const SimulatedWorld& a, const SimulatedWorld& b, int frame) {
  cv::Mat difference;
  cv::absdiff(a.render(frame), b.render(frame), difference);
  return cv::countNonZero(difference > 8) / static_cast<double>(difference.total());
}

TEST(SimulatedWorld, EventsHappenWhenTheyShould) {
  SimulationOptions options;
  options.world = "wall";
  options.motion = "sideways";
  options.noise = 0;
  const SimulatedWorld plain(options);
  options.event_from_s = 5;
  options.event_for_s = 4;
  for (const auto& [event, least, most] :
       {std::tuple{"black", 0.95, 1.0}, {"covered", 0.45, 0.52}}) {
    options.event = event;
    const SimulatedWorld world(options);
    for (const int frame : {90, 190}) EXPECT_EQ(changed_share(world, plain, frame), 0) << event;
    const double changed = changed_share(world, plain, 140);
    EXPECT_GE(changed, least) << event;
    EXPECT_LE(changed, most) << event;
  }
}

// In front of the houses, as far away as its depth says, and only for a while.
TEST(SimulatedWorld, ABusDrivesThroughTheStreet) {
  SimulationOptions options;
  options.world = "street";
  options.motion = "sideways";
  options.noise = 0;
  options.event_from_s = 5;
  options.event_for_s = 4;
  const SimulatedWorld plain(options);
  options.event = "bus";
  const SimulatedWorld world(options);
  for (const int frame : {90, 190}) EXPECT_EQ(changed_share(world, plain, frame), 0);
  EXPECT_GT(changed_share(world, plain, 140), 0.2);
  EXPECT_LT(changed_share(world, plain, 140), 0.45);
  const cv::Mat without = plain.depth(140), with = world.depth(140);
  EXPECT_NEAR(with.at<float>(240, 320), 5.8, 0.3);
  EXPECT_GT(without.at<float>(240, 320), 10);
  EXPECT_EQ(cv::countNonZero(with > without), 0);
}

TEST(SimulatedWorld, PointsAreOnTheGroundOrAboveIt) {
  const SimulatedWorld world;
  const Camera& camera = world.camera();
  for (int frame = 0; frame < world.num_frames(); frame += 90) {
    const cv::Mat depth = world.depth(frame);
    const Rigid3 pose = world.world_from_camera(frame);
    int on_ground = 0, seen = 0;
    for (int row = 0; row < camera.height; row += 2)
      for (int column = 0; column < camera.width; column += 2) {
        if (depth.at<float>(row, column) == 0) continue;
        const Eigen::Vector3d x = pose * point_of(camera, depth, column, row);
        ++seen;
        ASSERT_LT(x.y(), 2e-3);
        if (x.y() < 0.01 && x.y() > -2e-3) ++on_ground;
        if (x.y() > -2) {  // below the eaves nothing is outside the yard
          ASSERT_LT(std::abs(x.x()), 12.01);
          ASSERT_LT(std::abs(x.z()), 9.01);
        }
      }
    EXPECT_GT(on_ground, seen / 8) << frame;
  }
}

TEST(SimulatedWorld, SameOptionsSameImagesInAnyOrder) {
  SimulationOptions options;
  options.num_frames = 40;
  const SimulatedWorld world(options), again(options);
  const auto same = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_INF) == 0;
  };
  const cv::Mat seventh = world.render(7);
  EXPECT_FALSE(same(world.render(8), seventh));
  EXPECT_TRUE(same(world.render(7), seventh));
  EXPECT_TRUE(same(again.render(7), seventh));
  EXPECT_THROW(world.render(40), std::out_of_range);
  EXPECT_THROW(world.time_us(-1), std::out_of_range);
  EXPECT_EQ(world.time_us(3) - world.time_us(2), 50000);
  options.seed = 2;
  EXPECT_FALSE(same(SimulatedWorld(options).render(7), seventh));
}

TEST(SimulatedWorld, NoiseIsAsStrongAsAskedFor) {
  SimulationOptions options;
  options.noise = 0;
  const cv::Mat clean = SimulatedWorld(options).render(30);
  options.noise = 3;
  const cv::Mat noisy = SimulatedWorld(options).render(30);
  cv::Mat difference;
  cv::subtract(noisy, clean, difference, cv::noArray(), CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(difference, mean, deviation);
  EXPECT_NEAR(mean[0], 0, 0.05);
  EXPECT_NEAR(deviation[0], 3, 0.15);
}

// A lens moves what a pinhole sees, and changes nothing else. Pixels of `bent` that both see.
int expect_bent(const SimulatedWorld& bent, const SimulatedWorld& straight) {
  const cv::Mat a = straight.render(100), b = bent.render(100);
  std::vector<double> differences, unbent;
  for (int row = 0; row < b.rows; row += 3)
    for (int column = 0; column < b.cols; column += 3) {
      const Eigen::Vector2d n = bent.camera().normalized_from_pixel({column, row});
      const Eigen::Vector2d p = straight.camera().pixel_from_normalized(n);
      if (!inside(a, p)) continue;
      differences.push_back(
          std::abs(sample<std::uint8_t>(a, p.x(), p.y()) - b.at<std::uint8_t>(row, column)));
      unbent.push_back(std::abs(a.at<std::uint8_t>(row, column) - b.at<std::uint8_t>(row, column)));
    }
  EXPECT_LT(median(differences), 2);
  EXPECT_GT(median(unbent), 4);
  return static_cast<int>(differences.size());
}

TEST(SimulatedWorld, ADistortedImageIsThePinholesBent) {
  SimulationOptions options;
  options.noise = 0;
  const SimulatedWorld straight(options);
  options.distorted = true;
  const SimulatedWorld bent(options);
  ASSERT_EQ(bent.camera().model, CameraModel::kRadialTangential);
  EXPECT_GT(expect_bent(bent, straight), 25000);
}

TEST(SimulatedWorld, AFisheyeSeesThePinholesImageInItsMiddle) {
  SimulationOptions options;
  options.noise = 0;
  const SimulatedWorld straight(options);
  options.fisheye = true;
  const SimulatedWorld bent(options);
  const Camera& camera = bent.camera();
  ASSERT_EQ(camera.model, CameraModel::kFisheye);
  ASSERT_EQ(camera.problem(), "");
  EXPECT_GT(expect_bent(bent, straight), 8000);
  // 121 degrees wide and all of it in view.
  EXPECT_NEAR(std::atan(camera.normalized_from_pixel({639, 239.5}).x()), 0.5 * 121 * M_PI / 180,
              0.01);
  EXPECT_TRUE(camera.normalized_from_pixel({0, 0}).allFinite());
  options.distorted = true;
  EXPECT_NE(options.problem().find("fisheye"), std::string::npos);
}

TEST(SimulatedWorld, SaysWhichOptionIsWrong) {
  SimulationOptions options;
  options.world = "moon";
  EXPECT_NE(options.problem().find("'moon'"), std::string::npos);
  EXPECT_THROW(SimulatedWorld{options}, std::invalid_argument);
  options = {};
  options.motion = "jump";
  EXPECT_NE(options.problem().find("'jump'"), std::string::npos);
  options.motion = "drive";
  EXPECT_NE(options.problem().find("courtyard"), std::string::npos);
  options = {};
  options.event = "bus";
  EXPECT_NE(options.problem().find("street"), std::string::npos);
  options.event = "kidnapped";
  options.event_to_s = -1;
  EXPECT_NE(options.problem().find("event_to_s"), std::string::npos);
  options.motion = "pan";
  EXPECT_NE(options.problem().find("another motion"), std::string::npos);
  options = {};
  options.event = "rain";
  EXPECT_NE(options.problem().find("'rain'"), std::string::npos);
  options = {};
  options.roll_deg = -1;
  EXPECT_NE(options.problem().find("roll_deg"), std::string::npos);
}

}  // namespace
}  // namespace eifmap
