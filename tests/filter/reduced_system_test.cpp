// S summed bit by bit as the map changes, against S summed anew.
#include "filter/reduced_system.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace eifmap {
namespace {

class World {
 public:
  explicit World(unsigned seed) : random_(seed) {
    for (int i = 0; i < 12; ++i) add_landmark();
  }

  void add_landmark() {
    landmarks_.push_back({});
    const int first = draw(std::max(1, num_poses_ - 3));
    for (int pose = first; pose < std::min(num_poses_, first + 4); ++pose)
      if (std::count(removed_.begin(), removed_.end(), pose) == 0) add_sight(pose);
  }

  void add_pose() {
    ++num_poses_;
    for (int i = 0; i < 5; ++i) add_landmark();
    edges_.push_back({});
    FilterEdge& edge = edges_.write_back();
    edge.i = num_poses_ - 2;
    edge.j = num_poses_ - 1;
    for (RelativePoseLinearization* l : {&edge.frozen, &edge.now}) {
      l->d_i.setRandom();
      l->d_j.setRandom();
      l->residual.setRandom();
    }
  }

  // Of a landmark drawn: linearized anew, a sight more, a sight less, or all gone.
  void change() {
    FilterLandmark& landmark = landmarks_.write(draw(static_cast<int>(landmarks_.size())));
    const int what = draw(10);
    if (what == 0 || (what < 4 && !landmark.measurements.empty())) system_.before_removal(landmark);
    if (what == 0) landmark.measurements.clear();
    if (what > 0 && what < 4 && !landmark.measurements.empty())
      landmark.measurements.erase(landmark.measurements.begin());
    for (PointMeasurement& m : landmark.measurements)
      if (what > 5) linearize(m);
    landmark.changed = true;
  }

  void sum() {
    std::vector<int> touched;
    for (std::size_t l = 0; l < landmarks_.size(); ++l)
      if (landmarks_[l].changed) touched.push_back(static_cast<int>(l));
    system_.sum(index(), landmarks_, touched, edges_, absolutes_, Eigen::Vector3d::UnitX());
  }

  // Blocks that are no longer any landmark's stay, with zeros.
  void expect_as_if_new() const {
    FilterLandmarks landmarks = landmarks_;
    FilterEdges edges = edges_;
    std::vector<FilterAbsolute> absolutes = absolutes_;
    std::vector<int> touched;
    for (std::size_t l = 0; l < landmarks.size(); ++l) {
      landmarks.write(l).changed = true;
      touched.push_back(static_cast<int>(l));
    }
    for (std::size_t e = 0; e < edges.size(); ++e) edges.write(e).changed = true;
    for (FilterAbsolute& absolute : absolutes) absolute.changed = true;
    ReducedSystem anew;
    if (earth_after_ > 0) anew.append_earth(earth_after_);
    for (const int pose : removed_) anew.remove(pose);
    anew.sum(index(), landmarks, touched, edges, absolutes, Eigen::Vector3d::UnitX());
    // The same blocks, but for those of removed poses, which one of them may have dropped.
    const PoseBlocks &has = system_.blocks(), &wants = anew.blocks();
    ASSERT_EQ(system_.matrix().size(), has.count(num_poses_));
    const auto place = [&](int block) { return wants.of(has.pose(block)); };
    for (int a = 0; a < system_.matrix().size(); ++a) {
      const BlockColumn& have = system_.matrix().column(a);
      const BlockColumn& want = anew.matrix().column(place(a));
      for (std::size_t k = 0; k < have.row.size(); ++k) {
        const int at = want.find(place(have.row[k]));
        EXPECT_EQ(have.block[k], at < 0 ? PoseBlock::Zero() : want.block[at])
            << have.row[k] << ", " << a;
      }
      for (int b : want.row) EXPECT_GE(have.find(has.of(wants.pose(b))), 0);
      EXPECT_EQ(system_.right_side().segment<6>(6 * a), anew.right_side().segment<6>(6 * place(a)));
    }
    for (int pose = 1; pose < num_poses_; ++pose)
      if (std::count(removed_.begin(), removed_.end(), pose) == 0) {
        ASSERT_GE(has.of(pose), 0);
        EXPECT_EQ(has.pose(has.of(pose)), pose);
      }
    EXPECT_EQ(has.has_earth(), earth_after_ > 0);
    if (has.has_earth()) {
      EXPECT_EQ(has.pose(has.earth()), kEarthFromMap);
    }
  }

  // One that is in use, and neither of the gauge nor the newest nor measured absolutely.
  void remove_pose() {
    const auto must_stay = [this](int pose) {
      const auto is_of = [pose](const PoseRows& rows) { return rows.pose == pose; };
      return std::count(removed_.begin(), removed_.end(), pose) > 0 ||
             std::any_of(absolutes_.begin(), absolutes_.end(), [&](const FilterAbsolute& a) {
               return std::any_of(a.now.of_pose.begin(), a.now.of_pose.end(), is_of);
             });
    };
    int pose = 4 + draw(num_poses_ - 5);
    while (must_stay(pose)) pose = 4 + draw(num_poses_ - 5);
    for (std::size_t l = 0; l < landmarks_.size(); ++l) {
      const auto of_pose = [pose](const PointMeasurement& m) { return m.pose == pose; };
      const std::vector<PointMeasurement>& sights = landmarks_[l].measurements;
      if (std::none_of(sights.begin(), sights.end(), of_pose)) continue;
      system_.before_removal(landmarks_[l]);
      std::erase_if(landmarks_.write(l).measurements, of_pose);
      landmarks_.write(l).changed = true;
    }
    const auto ends_in = [pose](const FilterEdge& e) { return e.i == pose || e.j == pose; };
    for (const FilterEdge& edge : edges_)
      if (ends_in(edge)) system_.before_removal(edge);
    edges_.erase_if(ends_in);
    system_.remove(pose);
    removed_.push_back(pose);
  }
  bool drop_removed() { return system_.drop_removed(num_poses_); }
  int num_in_use() const { return num_poses_ - static_cast<int>(removed_.size()); }

  // An edge goes, another comes.
  void change_edges() {
    if (edges_.size() < 2) return;
    system_.before_removal(edges_[0]);
    int n = 0;
    edges_.erase_if([&n](const FilterEdge&) { return n++ == 0; });
    edges_.write_back().frozen.d_i.setRandom();
    edges_.write_back().changed = true;
  }

  // Earth comes, and with it a position and the length of a way.
  void add_earth() {
    earth_after_ = num_poses_;
    system_.append_earth(num_poses_);
    add_absolute({0, kEarthFromMap});
    add_absolute({num_poses_ - 1, kEarthFromMap});
    add_absolute({1, 3, 2});
  }
  void add_absolute(const std::vector<int>& poses) {
    absolutes_.emplace_back();
    for (int pose : poses)
      absolutes_.back().frozen.of_pose.push_back({pose, Eigen::Matrix<double, 3, 6>::Random()});
    absolutes_.back().now = absolutes_.back().frozen;
    absolutes_.back().now.residual.setRandom();
  }

  const ReducedSystem& system() const { return system_; }
  void mark_factored() { system_.mark_factored(); }
  int num_marked() const {
    int marked = 0;
    for (int a = 0; a < system_.matrix().size(); ++a) {
      const BlockColumn& column = system_.matrix().column(a);
      marked += static_cast<int>(std::count(column.changed.begin(), column.changed.end(), 1));
    }
    return marked;
  }

 private:
  PoseIndex index() const {
    PoseIndex index;
    for (int p = 0; p < num_poses_; ++p) index.add_pose();
    for (std::size_t l = 0; l < landmarks_.size(); ++l)
      for (const PointMeasurement& m : landmarks_[l].measurements)
        index.add(m.pose, static_cast<int>(l));
    return index;
  }
  int draw(int below) { return std::uniform_int_distribution<int>(0, below - 1)(random_); }
  void linearize(PointMeasurement& m) {
    for (SightRows* rows : {&m.frozen, &m.now}) rows->at.setRandom(), rows->to_landmark.setRandom();
    m.scale = 1;
    m.residual.setRandom();
    m.linearized = true;
  }
  void add_sight(int pose) {
    PointMeasurement m;
    m.pose = pose;
    linearize(m);
    landmarks_.write_back().measurements.push_back(m);
  }

  std::mt19937 random_;
  int num_poses_ = 5;
  FilterLandmarks landmarks_;
  FilterEdges edges_;
  std::vector<FilterAbsolute> absolutes_;
  int earth_after_ = 0;       // poses
  std::vector<int> removed_;  // poses
  ReducedSystem system_;
};

TEST(ReducedSystem, IsToTheBitWhatSummingAllOfItGives) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    World world(seed);
    world.sum();
    for (int step = 0; step < 15; ++step) {
      if (step % 3 == 2) world.add_pose();
      world.change();
      if (step % 5 == 4) world.change_edges();
      world.sum();
      ASSERT_NO_FATAL_FAILURE(world.expect_as_if_new()) << "seed " << seed << " step " << step;
    }
  }
}

TEST(ReducedSystem, IsSoWithAbsoluteMeasurements) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    World world(seed);
    world.sum();
    world.add_pose();
    world.add_earth();
    for (int step = 0; step < 9; ++step) {
      if (step % 3 == 2) {
        world.add_pose();
        world.add_absolute({5 + step / 3, kEarthFromMap});
      }
      world.change();
      if (step % 5 == 4) world.change_edges();
      world.sum();
      ASSERT_NO_FATAL_FAILURE(world.expect_as_if_new()) << "seed " << seed << " step " << step;
    }
  }
}

// Of a map whose keyframes go as others come, the matrix does not grow, and nothing is summed again
// for it.
TEST(ReducedSystem, DropsRemovedPoses) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    World world(seed);
    const bool has_earth = seed % 2 == 0;
    for (int i = 0; i < 20; ++i) world.add_pose();
    world.sum();
    int dropped = 0;
    for (int step = 0; step < 60; ++step) {
      world.add_pose();
      world.change();
      if (step % 4 > 0) world.remove_pose();
      if (has_earth && step == 30) world.add_earth();
      if (step % 3 > 0) continue;  // several came and went since the last sum
      const bool now = world.drop_removed();
      dropped += now;
      world.sum();
      ASSERT_NO_FATAL_FAILURE(world.expect_as_if_new()) << "seed " << seed << " step " << step;
      if (!now) continue;
      EXPECT_EQ(world.system().matrix().size(), world.num_in_use() - 1 + (has_earth && step > 30));
      const int all = static_cast<int>(world.system().matrix().num_blocks());
      EXPECT_EQ(world.num_marked(), all) << "what was factored is of no use";
      EXPECT_LT(world.system().num_blocks_summed(), all);
    }
    EXPECT_GE(dropped, 2);
    EXPECT_LT(world.system().matrix().size(), world.num_in_use() + 16 + world.num_in_use() / 4);
  }
}

TEST(ReducedSystem, SumsOnlyWhatChanged) {
  World world(3);
  for (int i = 0; i < 20; ++i) world.add_pose();
  world.sum();
  const int all = static_cast<int>(world.system().matrix().num_blocks());
  EXPECT_EQ(world.system().num_blocks_summed(), all);
  world.sum();
  EXPECT_EQ(world.system().num_blocks_summed(), 0);
  world.change();
  world.sum();
  EXPECT_LE(world.system().num_blocks_summed(), 10);  // four poses meet in ten blocks
}

// Several steps of the latest poses alone come between two factorizations.
TEST(ReducedSystem, MarksWhatChangedUntilItIsFactored) {
  World world(4);
  world.sum();
  world.mark_factored();
  EXPECT_EQ(world.num_marked(), 0);
  for (int i = 0; i < 5; ++i) world.change();
  world.sum();
  const int marked = world.num_marked();
  EXPECT_GT(marked, 0);
  world.sum();
  EXPECT_EQ(world.num_marked(), marked);
  world.mark_factored();
  EXPECT_EQ(world.num_marked(), 0);
}

// A sight that came after the last sum, and is gone before the next, is in no pattern yet.
TEST(ReducedSystem, TakesWhatCameAndWentBetweenTwoSums) {
  World world(5);
  world.sum();
  world.add_pose();
  for (int i = 0; i < 30; ++i) world.change();
  world.sum();
  world.expect_as_if_new();
}

}  // namespace
}  // namespace eifmap
