// Half the focal length is found out, and the right one is never: rendered here, recorded where the
// data are there.
#include "map/calibration_check.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>

#include "features/front_end.h"
#include "map/observed_frame.h"
#include "sequence/recorded_sequence.h"
#include "simulation/simulated_world.h"

namespace eifmap {
namespace {

using Verdict = CalibrationCheck::Verdict;

Camera with_focal(Camera camera, double factor) {
  camera.fx *= factor;
  camera.fy *= factor;
  return camera;
}

std::vector<Match> matches_of(const FeatureFrame& i, const FeatureFrame& j, const Camera& camera) {
  const MapperOptions options;
  const ObservedFrame a = observe(i, camera, MapSign::kMinus, options.sigma_factor);
  const ObservedFrame b = observe(j, camera, MapSign::kMinus, options.sigma_factor);
  // What is beyond the view is left out of an observed frame, and would shift the numbers.
  if (a.size() != static_cast<int>(i.keypoints.size()) ||
      b.size() != static_cast<int>(j.keypoints.size()))
    throw std::logic_error("a keypoint is out of view");
  std::vector<Match> matches = match_omega_p(a, b, options.match);
  const std::vector<Match> more = match_omega_m(a, b, options.match);
  matches.insert(matches.end(), more.begin(), more.end());
  return matches;
}

struct Pairs {
  Camera camera;
  std::vector<FeatureFrame> frames;  // each with the next
};

Pairs every(int step, int number, const Camera& camera, const std::function<cv::Mat(int)>& image) {
  Pairs pairs{camera, {}};
  FeatureExtractor extractor;
  for (int k = 0; k < number; ++k)
    pairs.frames.push_back(
        extract_frame(extractor, image(k * step), camera, {1000000 * (k + 1), 1, k, "cam0"}));
  return pairs;
}

// The verdict on the true focal length times `factor`.
CalibrationCheck judged(const Pairs& pairs, double factor) {
  CalibrationCheck check(with_focal(pairs.camera, factor), {});
  for (std::size_t k = 0; k + 1 < pairs.frames.size(); ++k)
    check.add_pair(pairs.frames[k], pairs.frames[k + 1],
                   matches_of(pairs.frames[k], pairs.frames[k + 1], pairs.camera));
  return check;
}

Pairs rendered(const char* motion, bool distorted, bool fisheye) {
  SimulationOptions options;
  options.motion = motion;
  options.distorted = distorted;
  options.fisheye = fisheye;
  const SimulatedWorld world(options);
  return every(12, 8, world.camera(), [&world](int i) { return world.render(i); });
}

TEST(CalibrationCheck, FindsHalfAndDoubleTheFocalLength) {
  const Pairs pairs = rendered("lap", false, false);
  for (const double factor : {0.5, 0.7, 1.4, 2.0}) {
    const CalibrationCheck check = judged(pairs, factor);
    EXPECT_EQ(check.verdict(), Verdict::kSuspect) << factor;
    EXPECT_NE(check.detail().find("focal length"), std::string::npos);
  }
  EXPECT_NE(judged(pairs, 0.5).detail().find("(459 px)"), std::string::npos)
      << judged(pairs, 0.5).detail();
}

TEST(CalibrationCheck, TrustsWhatIsRightOrAlmost) {
  for (const bool fisheye : {false, true}) {
    const Pairs pairs = rendered("lap", !fisheye, fisheye);
    for (const double factor : {0.95, 1.0, 1.05})
      EXPECT_EQ(judged(pairs, factor).verdict(), Verdict::kTrusted) << fisheye << ' ' << factor;
  }
}

// No turn, no verdict: a plane or a straight way fits any focal length.
TEST(CalibrationCheck, HasNoVerdictWhereNothingTells) {
  SimulationOptions options;
  options.world = "wall";
  options.motion = "sideways";
  const SimulatedWorld world(options);
  const Pairs pairs = every(10, 6, world.camera(), [&world](int i) { return world.render(i); });
  for (const double factor : {0.5, 1.0})
    EXPECT_EQ(judged(pairs, factor).verdict(), Verdict::kOpen) << factor;
}

struct Recorded {
  const char* name;
  int step, number;
};

class CalibrationCheckRecorded : public testing::TestWithParam<Recorded> {};

TEST_P(CalibrationCheckRecorded, RightIsNotSuspectAndHalfIs) {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path folder =
      std::filesystem::path(shared ? shared : EIFMAP_SHARED_DEFAULT) / "data" / GetParam().name;
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no " << folder;
  RecordedSequence::Opened opened = RecordedSequence::open(folder);
  ASSERT_TRUE(opened.sequence) << opened.problem;
  const RecordedSequence& sequence = *opened.sequence;
  const Pairs pairs = every(GetParam().step, GetParam().number, sequence.camera(),
                            [&sequence](int i) { return sequence.load_gray(i).image; });
  for (const double factor : {0.95, 1.0, 1.05})
    EXPECT_NE(judged(pairs, factor).verdict(), Verdict::kSuspect) << factor;
  EXPECT_EQ(judged(pairs, 0.5).verdict(), Verdict::kSuspect);
}

INSTANTIATE_TEST_SUITE_P(Folders, CalibrationCheckRecorded,
                         testing::Values(Recorded{"kitti00", 5, 40}, Recorded{"kitchen", 30, 20},
                                         Recorded{"fountain", 1, 11}),
                         [](const auto& case_) { return std::string(case_.param.name); });

}  // namespace
}  // namespace eifmap
