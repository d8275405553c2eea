#include "client/demo/in_process_run.h"

#include <gtest/gtest.h>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

std::unique_ptr<ImageSource> walk(int frames) {
  SimulationOptions options;
  options.num_frames = frames;
  return make_source(SimulatedWorld(options));
}

bool go_on(int) {
  return true;
}

// Images and the features extracted from them make the same trajectory, byte for byte, and what the
// client logged is what the server says it published.
TEST(InProcessRun, ImagesAndFeaturesGiveTheSameTrajectory) {
  const auto source = walk(45);
  const TemporaryFolder folder;
  std::string trajectories[2];
  for (const auto as : {PublishAs::kRaw, PublishAs::kFeatures}) {
    const auto output = folder.path() / (as == PublishAs::kRaw ? "raw" : "features");
    const auto result = run_in_process(*source, {output, as}, go_on);
    EXPECT_EQ(result.problem, "");
    EXPECT_EQ(result.poses, 45);
    EXPECT_GT(result.tracked, 25);
    EXPECT_GT(result.points.size(), 100u);
    const std::string trajectory = read_text(output / "trajectory.tum");
    EXPECT_EQ(trajectory, read_text(output / "log" / "trajectory.tum"));
    trajectories[as == PublishAs::kFeatures] = trajectory;
  }
  EXPECT_FALSE(trajectories[0].empty());
  EXPECT_EQ(trajectories[0], trajectories[1]);
}

TEST(InProcessRun, AViewIsFilledToo) {
  const auto source = walk(45);
  const TemporaryFolder folder;
  View view;
  const auto result = run_in_process(*source, {folder.path(), PublishAs::kRaw, &view}, go_on);
  EXPECT_EQ(result.problem, "");
  view.model.take_increment(ViewModel::Clock::now());
  const auto shown = nlohmann::json::parse(view.model.snapshot());
  EXPECT_EQ(shown.at("path").at("steps").size(), 4 * static_cast<std::size_t>(result.tracked));
  EXPECT_EQ(shown.at("landmarks").size(), 7 * result.points.size());
  EXPECT_EQ(shown.at("state").at("state"), "STOPPED");
  EXPECT_EQ(shown.at("camera"), "demo");
  EXPECT_EQ(view.picture.jpeg().substr(0, 2), "\xff\xd8");
}

// Some images have too few pixels: the server refuses them, which no pose message tells.
class DamagedSource : public DerivedSource {
 public:
  using DerivedSource::DerivedSource;
  GrayImage gray(int i) override {
    GrayImage gray = source_->gray(i);
    if (i % 3 == 1) gray.image = gray.image.rowRange(0, 100).clone();
    return gray;
  }
};

TEST(InProcessRun, EndsThoughImagesAreRefused) {
  DamagedSource source(walk(20));
  const TemporaryFolder folder;
  const auto result = run_in_process(source, {folder.path(), PublishAs::kRaw}, go_on);
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(result.poses, 13);  // of 20, all but 1, 4, ... 19
}

TEST(InProcessRun, StopsWhenAsked) {
  const TemporaryFolder folder;
  const auto result = run_in_process(*walk(400), {folder.path(), PublishAs::kRaw},
                                     [](int done) { return done < 5; });
  EXPECT_EQ(result.problem, "stopped");
  EXPECT_LT(result.poses, 50);
}

}  // namespace
}  // namespace eifmap
