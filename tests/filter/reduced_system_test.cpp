// S summed bit by bit as the map changes, against S summed anew.
#include "filter/reduced_system.h"

#include <gtest/gtest.h>

#include <random>

namespace eifmap {
namespace {

class World {
 public:
  explicit World(unsigned seed) : random_(seed) {
    for (int i = 0; i < 12; ++i) add_landmark();
  }

  void add_landmark() {
    landmarks_.emplace_back();
    const int first = draw(std::max(1, num_poses_ - 3));
    for (int pose = first; pose < std::min(num_poses_, first + 4); ++pose) add_sight(pose);
  }

  void add_pose() {
    ++num_poses_;
    for (int i = 0; i < 5; ++i) add_landmark();
    edges_.emplace_back();
    FilterEdge& edge = edges_.back();
    edge.i = num_poses_ - 2;
    edge.j = num_poses_ - 1;
    edge.linearization.d_i.setRandom();
    edge.linearization.d_j.setRandom();
    edge.linearization.residual.setRandom();
  }

  // Of a landmark drawn: linearized anew, a sight more, a sight less, or all gone.
  void change() {
    FilterLandmark& landmark = landmarks_[draw(static_cast<int>(landmarks_.size()))];
    const int what = draw(10);
    if (what == 0 || (what < 4 && !landmark.measurements.empty())) system_.before_removal(landmark);
    if (what == 0) landmark.measurements.clear();
    if (what > 0 && what < 4 && !landmark.measurements.empty())
      landmark.measurements.erase(landmark.measurements.begin());
    for (PointMeasurement& m : landmark.measurements)
      if (what > 5) linearize(m);
    landmark.changed = true;
  }

  void sum() { system_.sum(num_poses_, landmarks_, edges_, false); }

  void expect_as_if_new() const {
    std::vector<FilterLandmark> landmarks = landmarks_;
    for (FilterLandmark& landmark : landmarks) landmark.changed = true;
    ReducedSystem anew;
    anew.sum(num_poses_, landmarks, edges_, false);
    EXPECT_EQ(system_.matrix().row, anew.matrix().row);
    EXPECT_EQ(system_.matrix().start, anew.matrix().start);
    ASSERT_EQ(system_.matrix().block.size(), anew.matrix().block.size());
    for (std::size_t k = 0; k < anew.matrix().block.size(); ++k)
      EXPECT_EQ(system_.matrix().block[k], anew.matrix().block[k]) << "block " << k;
    EXPECT_EQ(system_.right_side(), anew.right_side());
  }

  const ReducedSystem& system() const { return system_; }

 private:
  int draw(int below) { return std::uniform_int_distribution<int>(0, below - 1)(random_); }
  void linearize(PointMeasurement& m) {
    m.d_pose.setRandom();
    m.d_landmark.setRandom();
    m.residual.setRandom();
    m.linearized = true;
  }
  void add_sight(int pose) {
    PointMeasurement m;
    m.pose = pose;
    linearize(m);
    landmarks_.back().measurements.push_back(m);
  }

  std::mt19937 random_;
  int num_poses_ = 5;
  std::vector<FilterLandmark> landmarks_;
  std::vector<FilterEdge> edges_;
  ReducedSystem system_;
};

TEST(ReducedSystem, IsToTheBitWhatSummingAllOfItGives) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    World world(seed);
    world.sum();
    for (int step = 0; step < 15; ++step) {
      if (step % 3 == 2) world.add_pose();
      world.change();
      world.sum();
      ASSERT_NO_FATAL_FAILURE(world.expect_as_if_new()) << "seed " << seed << " step " << step;
    }
  }
}

TEST(ReducedSystem, SumsOnlyWhatChanged) {
  World world(3);
  for (int i = 0; i < 20; ++i) world.add_pose();
  world.sum();
  const int all = static_cast<int>(world.system().matrix().block.size());
  EXPECT_EQ(world.system().num_blocks_summed(), all);
  world.sum();
  EXPECT_EQ(world.system().num_blocks_summed(), 0);
  world.change();
  world.sum();
  EXPECT_LE(world.system().num_blocks_summed(), 10);  // four poses meet in ten blocks
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
