// A client that adds up the updates holds the map.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <map>
#include <set>

#include "mapper.h"
#include "support/feature_world.h"

namespace eifmap::test {
namespace {

TEST(MapNews, UpdatesAddUpToTheMap) {
  const SyntheticStream world;
  Mapper mapper(synthetic_camera(), {});
  std::map<std::int64_t, KeyframeView> keyframes;
  std::map<std::int64_t, LandmarkView> landmarks;
  std::map<std::int64_t, std::set<std::int64_t>> seen_from;  // keyframes, by landmark
  std::int64_t seq = -1;
  int updates = 0;
  for (int i = 0; i < 60; ++i) {
    const FrameResult result =
        mapper.process(world.view(i, {so3_exp({0, 0.002 * i, 0}), {0.1 * i, 0, 0}}));
    if (!result.map_updated) continue;
    ++updates;
    const MapUpdate update = mapper.map_update();
    EXPECT_EQ(update.base_seq, seq);
    EXPECT_GT(update.seq, seq);
    seq = update.seq;
    for (const KeyframeView& k : update.keyframes) {
      keyframes[k.id] = k;
      // The first keyframe is the map's frame; of all others something is unknown, and said.
      const Eigen::VectorXd values =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(k.covariance).eigenvalues();
      EXPECT_EQ(k.id == 0, !(values[5] > 0)) << k.id;
      EXPECT_GT(values[0], -1e-9 * values[5] - 1e-30) << k.id;
    }
    for (const LandmarkView& l : update.landmarks) {
      landmarks[l.id] = l;
      EXPECT_GT(l.covariance.llt().matrixL().determinant(), 0) << l.id;
    }
    for (const std::int64_t id : update.removed_landmarks) {
      EXPECT_EQ(landmarks.erase(id), 1u);
      seen_from.erase(id);
    }
    for (const ObservationView& o : update.observations) {
      EXPECT_TRUE(keyframes.contains(o.keyframe));
      EXPECT_TRUE(landmarks.contains(o.landmark));
      EXPECT_TRUE(seen_from[o.landmark].insert(o.keyframe).second) << "said once";
    }
    for (const ObservationView& o : update.removed_observations)
      EXPECT_EQ(seen_from[o.landmark].erase(o.keyframe), 1u);
    for (const LandmarkView& now : mapper.landmarks()) {
      EXPECT_EQ(static_cast<int>(seen_from[now.id].size()), now.num_observations);
      const LandmarkView& sent = landmarks.at(now.id);
      EXPECT_EQ(sent.anchor, now.anchor);
      const Eigen::Vector3d step = sent.position_in_anchor - now.position_in_anchor;
      EXPECT_LE(step.norm(), 0.011 * now.position_in_anchor.norm()) << "else sent again";
    }
    ASSERT_EQ(static_cast<std::int64_t>(keyframes.size()), mapper.statistics().keyframes);
    ASSERT_EQ(static_cast<std::int64_t>(landmarks.size()), mapper.statistics().landmarks);
  }
  EXPECT_GT(updates, 5);

  // Placed by its keyframe, each landmark is where the mapper has one (to the update's threshold).
  const std::vector<MapPoint> points = mapper.map_points();
  ASSERT_EQ(points.size(), landmarks.size());
  std::size_t k = 0;
  for (const auto& [id, landmark] : landmarks) {
    const Eigen::Vector3d position =
        keyframes.at(landmark.anchor).map_from_camera * landmark.position_in_anchor;
    EXPECT_LT((position - points[k].position).norm(), 0.03 * points[k].position.norm()) << id;
    ++k;
  }
}

}  // namespace
}  // namespace eifmap::test
