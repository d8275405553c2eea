#include "server/step_timer.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

TEST(StepTimer, CountsFramesInWhichAStepRan) {
  StepTimer timer;
  for (int frame = 0; frame < 4; ++frame) {
    timer.begin_frame();
    for (int i = 0; i < 3; ++i) const TimedStep step(timer, "often");
    if (frame == 2) const TimedStep step(timer, "once");
    timer.end_frame();
  }
  const std::map<std::string, StepTime> summary = timer.summary();
  EXPECT_EQ(summary.at("frame").frames, 4);
  EXPECT_EQ(summary.at("often").frames, 4);
  EXPECT_EQ(summary.at("once").frames, 1);
  for (const auto& [name, time] : summary) {
    EXPECT_GE(time.median_ms, 0);
    EXPECT_GE(time.p99_ms, time.median_ms);
  }
  EXPECT_GE(summary.at("frame").total_s, summary.at("often").total_s);
}

TEST(StepTimer, KeepsNothingOfAFrameThatNobodyAsksFor) {
  StepTimer timer;
  for (int frame = 0; frame < 4; ++frame) {
    timer.begin_frame();
    for (int i = 0; i < 2 + frame; ++i) const TimedStep step(timer, "often");
    timer.end_frame(frame == 3);
  }
  const std::map<std::string, StepTime> summary = timer.summary();
  EXPECT_EQ(summary.at("often").frames, 1);
  EXPECT_EQ(summary.at("frame").frames, 1);
}

TEST(StepTimer, NothingWithoutFrames) {
  EXPECT_TRUE(StepTimer().summary().empty());
}

}  // namespace
}  // namespace eifmap
