#include "map/tracking_history.h"

#include <gtest/gtest.h>

namespace eifmap::test {
namespace {

Eigen::Vector2d along_x(double px) {
  return {px, 0};
}

TrackingHistory after_steps(std::initializer_list<double> steps_px) {
  TrackingHistory history;
  for (const double step : steps_px) history.add(along_x(step));
  return history;
}

TEST(TrackingHistory, AnImageShiftedOnceIsAnOddStep) {
  const TrackingHistory walk = after_steps({6, 7, 5, 6, 8, 7});
  EXPECT_FALSE(walk.is_odd_step(along_x(11)));  // too small to be told from a jerk
  EXPECT_FALSE(walk.is_odd_step(along_x(17)));
  EXPECT_TRUE(walk.is_odd_step(along_x(25)));
  EXPECT_TRUE(walk.is_odd_step(along_x(-25)));
}

TEST(TrackingHistory, TheWayBackIsNotOddAndTheNextShiftIs) {
  TrackingHistory history = after_steps({6, 7, 5, 6, 8, 7});
  for (const double shift : {60.0, -40.0, 25.0}) {
    EXPECT_TRUE(history.is_odd_step(along_x(shift)));
    history.add(along_x(shift));
    EXPECT_FALSE(history.is_odd_step(along_x(7 - shift)));
    history.add(along_x(7 - shift));
  }
}

TEST(TrackingHistory, TwoShiftsInARowAreBothOdd) {
  TrackingHistory history = after_steps({6, 7, 5, 6, 8, 7});
  history.add(along_x(40));
  EXPECT_TRUE(history.is_odd_step(along_x(-75)));  // from 40 px on one side to 35 on the other
  history.add(along_x(-75));
  EXPECT_FALSE(history.is_odd_step(along_x(40)));
}

TEST(TrackingHistory, ATurnThatBeginsIsOddAtMostOnce) {
  TrackingHistory history = after_steps({6, 7, 5, 6, 8, 7});
  int odd = 0;
  for (const double step : {25.0, 50.0, 80.0, 80.0, 80.0}) {
    odd += history.is_odd_step(along_x(step));
    history.add(along_x(step));
  }
  EXPECT_EQ(odd, 1);
}

TEST(TrackingHistory, LargeStepsAreNotOddWhereTheyAreUsual) {
  const TrackingHistory rare_images = after_steps({80, -20, 120, 60, -90, 15});
  EXPECT_FALSE(rare_images.is_odd_step(along_x(150)));
}

TEST(TrackingHistory, SaysNothingBeforeTheFirstStep) {
  EXPECT_FALSE(TrackingHistory().is_odd_step(along_x(500)));
}

}  // namespace
}  // namespace eifmap::test
