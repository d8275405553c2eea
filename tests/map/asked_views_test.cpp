// What is asked of a mapper about its map: two keyframes to each other, all of it in earth.
#include "map/asked_views.h"

#include <gtest/gtest.h>

#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

const Rigid3 kEarth{so3_exp({0.3, 1.2, -0.4}), {100, 200, -30}};
constexpr double kSigma = 0.02;  // m

// A walk, wavy so that positions say how earth is turned.
Rigid3 walk(int i) {
  return {so3_exp({0, 0.002 * i, 0}), {0.1 * i, 0.4 * std::sin(0.2 * i), 0.3 * std::cos(0.15 * i)}};
}

class AskedViews : public testing::Test {
 protected:
  void go(bool measured) {
    const SyntheticStream stream(3);
    test::Random random(5);
    for (int i = 0; i < 60; ++i) {
      const FeatureFrame frame = stream.view(i, walk(i));
      AbsoluteMeasurement m;
      m.time_us = frame.time_us;
      m.position = kEarth * walk(i).translation + kSigma * random.normal_vector<3>();
      m.covariance = kSigma * kSigma * Eigen::Matrix3d::Identity();
      if (measured && i % 3 == 0) {
        ASSERT_EQ(mapper_.add_measurement(m), Reason::kNone);
      }
      mapper_.process(frame);
    }
    ASSERT_GE(mapper_.keyframes().size(), 5u);
  }

  Mapper mapper_{synthetic_camera(), {}};
};

TEST_F(AskedViews, NothingIsKnownOfNoMap) {
  EXPECT_FALSE(mapper_.relative_pose(0, 1));
  EXPECT_FALSE(mapper_.in_earth());
  EXPECT_TRUE(mapper_.landmarks().empty());
}

TEST_F(AskedViews, TwoKeyframesToEachOther) {
  go(false);
  const std::vector<KeyframeView> keyframes = mapper_.keyframes();
  const KeyframeView &a = keyframes[2], &b = keyframes.back();
  const auto relative = mapper_.relative_pose(a.id, b.id);
  ASSERT_TRUE(relative);
  const Rigid3 expected = a.map_from_camera.inverse() * b.map_from_camera;
  EXPECT_EQ(relative->a_from_b.translation, expected.translation);
  EXPECT_EQ(relative->a_from_b.rotation.coeffs(), expected.rotation.coeffs());
  // Seen from the first, which is the map's frame, it is what the map says.
  const auto from_first = mapper_.relative_pose(0, b.id);
  ASSERT_TRUE(from_first);
  EXPECT_LT((from_first->covariance - b.covariance).norm(), 1e-9 * b.covariance.norm());
  // Of the same rotation, seen from the other side.
  const auto back = mapper_.relative_pose(b.id, a.id);
  ASSERT_TRUE(back);
  const Eigen::Matrix3d turn = expected.matrix();
  const Eigen::Matrix3d rotation = relative->covariance.bottomRightCorner<3, 3>();
  EXPECT_LT(
      (back->covariance.bottomRightCorner<3, 3>() - turn * rotation * turn.transpose()).norm(),
      1e-9 * rotation.norm());
  const auto itself = mapper_.relative_pose(a.id, a.id);
  ASSERT_TRUE(itself);
  EXPECT_TRUE(itself->covariance.isZero(0));
  EXPECT_FALSE(mapper_.relative_pose(a.id, 1000));
  EXPECT_FALSE(mapper_.relative_pose(-1, a.id));
  EXPECT_FALSE(mapper_.in_earth()) << "no positions";
}

TEST_F(AskedViews, ARemovedKeyframeIsNotInTheMap) {
  Map map(synthetic_camera(), {});
  const SyntheticStream stream;
  for (int k = 0; k < 3; ++k)
    map.add_keyframe(observe(stream.frame(k), synthetic_camera(), MapSign::kMinus, 2), {});
  map.remove_keyframe(2);
  EXPECT_FALSE(relative_view(map, 2, 2));
  EXPECT_TRUE(relative_view(map, 1, 1));
}

TEST_F(AskedViews, AllInEarth) {
  go(true);
  const auto view = mapper_.in_earth();
  ASSERT_TRUE(view);
  const std::vector<KeyframeView> keyframes = mapper_.keyframes();
  ASSERT_EQ(view->keyframes.size(), keyframes.size());
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const EarthView::Keyframe& keyframe = view->keyframes[k];
    EXPECT_EQ(keyframe.id, keyframes[k].id);
    EXPECT_EQ(keyframe.earth_from_camera.translation,
              view->earth_from_map * keyframes[k].map_from_camera.translation);
    const int i = static_cast<int>((keyframe.time_us - 1'000'000) / 100'000);
    const Eigen::Vector3d error =
        kEarth * walk(i).translation - keyframe.earth_from_camera.translation;
    const Eigen::Matrix3d covariance = keyframe.covariance.topLeftCorner<3, 3>();
    EXPECT_LT(error.dot(covariance.llt().solve(error)), 25) << k;  // of 3 degrees of freedom
    // Twenty positions of 0.02 m: nowhere surer than all of them together.
    EXPECT_GT(std::sqrt(covariance.trace() / 3), kSigma / 5);
    EXPECT_LT(std::sqrt(covariance.trace() / 3), 2 * kSigma);
  }
  const std::vector<LandmarkView> landmarks = mapper_.landmarks();
  ASSERT_EQ(view->landmarks.size(), landmarks.size());
  for (std::size_t l = 0; l < landmarks.size(); ++l) {
    EXPECT_EQ(view->landmarks[l].id, landmarks[l].id);
    EXPECT_GT(view->landmarks[l].covariance.trace(), 0);
  }
}

}  // namespace
}  // namespace eifmap
