// Runs made again from their decisions: to the bit, or it is said that they are not.
#include "server/replay.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>

#include "convert/camera_message.h"
#include "convert/image_message.h"
#include "convert/measurement_message.h"
#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"
#include "sequence/temporary_folder.h"
#include "server/camera_mapper.h"
#include "server/let_keyframe_in.h"
#include "server/sequence_run.h"
#include "simulation/simulated_world.h"
#include "support/own_folder.h"

namespace eifmap {
namespace {

constexpr int kImages = 70;

// The simulated courtyard, as a recorded folder and as messages.
class ReplayTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new SimulatedWorld;
    images_ = new std::vector<cv::Mat>;
    recorded_ = new TemporaryFolder;
    for (int i = 0; i < kImages; ++i) images_->push_back(world_->render(i));
    record(recorded_->path(), [](int) { return true; });
  }
  static void TearDownTestSuite() {
    delete recorded_;
    delete images_;
    delete world_;
  }

  template <class Wanted>
  static void record(const std::filesystem::path& folder, Wanted wanted) {
    test::OwnFolder images(folder);
    std::vector<TimedPose> truth;
    for (int i = 0; i < kImages; ++i) {
      if (!wanted(i)) continue;
      images.add(world_->time_us(i), (*images_)[static_cast<std::size_t>(i)]);
      truth.push_back({world_->time_us(i), world_->world_from_camera(i)});
    }
    images.finish(world_->camera(), truth);
  }

  static std::vector<std::uint8_t> message(int i, std::int64_t publisher,
                                           std::int64_t calibration_id) {
    const cv::Mat& pixels = (*images_)[static_cast<std::size_t>(i)];
    ImageMessage image;
    image.time_us = world_->time_us(i);
    image.publisher = publisher;
    image.seq = i;
    image.calibration_id = calibration_id;
    image.width = image.row_stride = pixels.cols;
    image.height = pixels.rows;
    image.data.assign(pixels.datastart, pixels.dataend);
    return encode(to_message(image));
  }

  static void calibrate(CameraMapper& mapper, const Camera& camera) {
    const NamedCamera named{1, "cam0", camera};
    ASSERT_EQ(mapper.take_calibration("cam0", encode(to_message(named))).reason, Reason::kNone);
  }

  std::filesystem::path measurements_of_all() const {
    std::string text;
    for (const AbsoluteMeasurement& m : measured_) text += line_of(m) + "\n";
    return folder_.write("measured.jsonl", text);
  }

  void measure(CameraMapper& mapper, int i) {
    const int image = std::clamp(i, 0, kImages - 1);
    AbsoluteMeasurement m;
    m.id = {8, next_measurement_++};
    m.time_us = world_->time_us(image) + 1000 * (i % 5);
    m.position = world_->world_from_camera(image).translation;
    m.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    const auto taken =
        mapper.take_measurement("cam0", encode(to_message(NamedMeasurement{"cam0", m})));
    ASSERT_EQ(taken.reason, Reason::kNone) << taken.detail;
    measured_.push_back(m);
  }

  // A live run that passes over some images, has time for the map after some, and whose publisher
  // is started again on the way.
  // `measured`: with true positions, that come in no order of their own. `reset_at`: before this
  // image all maps are given up.
  void run_live(InputMode input, int first = 0, bool measured = false, int reset_at = -1) {
    ServerConfig config;
    config.input = input;
    CameraMapper mapper(config);
    if (first > 0) {  // with another calibration up to there
      Camera other = world_->camera();
      other.fx *= 1.01;
      calibrate(mapper, other);
      for (int i = 0; i < first; ++i) mapper.take_frame(kImage, message(i, 3, other.id()));
      ASSERT_GT(mapper.statistics().starts, 0) << "so that the maps are counted on";
    }
    calibrate(mapper, world_->camera());
    for (int i = first; i < kImages; ++i) {
      const bool resets = i == reset_at && mapper.reset();
      ASSERT_EQ(resets, i == reset_at);
      if (measured && i % 3 == 1) measure(mapper, i);
      if (measured && i % 6 == 2)
        measure(mapper, i - 7), measure(mapper, i + 3), measure(mapper, i);
      if (i % 9 == 5) continue;
      const auto wire = message(i, i < 60 ? 3 : 4, world_->camera().id());
      const FrameResult result = mapper.take_frame(kImage, wire).result;
      ASSERT_FALSE(result.rejected);
      const Decision decision = decision_of(result);
      if (i % 7 == 3) mapper.take_frame(kImage, wire);  // again: refused
      if (i % 3 == 0) let_keyframe_in(mapper);
      all_decisions_.push_back(decision);
    }
    mapper.adopt_keyframe(true);
    ASSERT_GT(mapper.statistics().keyframes, 6);
    ASSERT_EQ(mapper.statistics().scale.status == ScaleStatus::kFixed, measured);
    ASSERT_EQ(mapper.write_results(live()), "");
  }

  static std::string replay(SequenceRunOptions options) {
    return run_sequence(options, [](int, int) { return true; });
  }
  SequenceRunOptions options() const {
    SequenceRunOptions options;
    options.sequence = recorded_->path();
    options.output = again();
    options.decisions = live() / "decisions.jsonl";
    return options;
  }
  std::filesystem::path live() const { return folder_.path() / "live"; }
  std::filesystem::path again() const { return folder_.path() / "again"; }

  std::vector<Decision> decisions() const {
    return read_decisions(live() / "decisions.jsonl").decisions;
  }

  void expect_same() const {
    for (const char* file : {"decisions.jsonl", "trajectory.tum", "trajectory_final.tum",
                             "keyframes.tum", "map.ply"}) {
      EXPECT_NE(read_text(live() / file), "") << file;
      EXPECT_EQ(read_text(live() / file), read_text(again() / file)) << file;
    }
  }

  static inline const Channel kImage{"cam0", ChannelKind::kImage};
  static inline std::int64_t next_measurement_ = 0;
  static inline SimulatedWorld* world_ = nullptr;
  static inline std::vector<cv::Mat>* images_ = nullptr;
  static inline TemporaryFolder* recorded_ = nullptr;
  const TemporaryFolder folder_;
  std::vector<AbsoluteMeasurement> measured_;
  std::vector<Decision> all_decisions_;  // as they are published
};

TEST_F(ReplayTest, OfALiveRunIsTheSameToTheBit) {
  run_live(InputMode::kNewest);
  const auto adopted = [](const Decision& d) { return d.adopted_job > 0; };
  const auto made = decisions();
  EXPECT_GT(std::count_if(made.begin(), made.end(), adopted), 4) << "else this shows little";
  EXPECT_EQ(replay(options()), "");
  expect_same();
}

TEST_F(ReplayTest, OfARunThatMapsAtOnceToo) {
  run_live(InputMode::kLossless);
  for (const Decision& decision : decisions()) EXPECT_LE(decision.adopted_job, 0);
  EXPECT_EQ(replay(options()), "");
  expect_same();
}

TEST_F(ReplayTest, OfWhatFollowedAnotherCalibrationToo) {
  run_live(InputMode::kNewest, 25);
  EXPECT_EQ(decisions().front().time_us, world_->time_us(25));
  EXPECT_EQ(replay(options()), "");
  expect_same();
}

TEST_F(ReplayTest, OfARunWithMeasurementsToo) {
  for (const InputMode input : {InputMode::kNewest, InputMode::kLossless}) {
    run_live(input, 0, true);
    SequenceRunOptions measured = options();
    EXPECT_NE(replay(measured).find("absolute measurements had a part in that run"),
              std::string::npos);
    measured.measurements = live() / "measurements.jsonl";
    EXPECT_EQ(replay(measured), "");
    expect_same();
    EXPECT_EQ(read_text(live() / "measurements.jsonl"), read_text(again() / "measurements.jsonl"));
  }
}

TEST_F(ReplayTest, WhatFollowedAnotherCalibrationHasItsMeasurements) {
  run_live(InputMode::kNewest, 25, true);
  SequenceRunOptions measured = options();
  measured.measurements = live() / "measurements.jsonl";
  EXPECT_EQ(replay(measured), "");
  expect_same();
}

// From the whole run's decisions, as a log has them, and from those of the results, which begin
// with the reset.
TEST_F(ReplayTest, OfARunThatWasResetToo) {
  for (const InputMode input : {InputMode::kNewest, InputMode::kLossless}) {
    all_decisions_.clear();
    run_live(input, 0, true, 27);
    const auto reset = [](const Decision& d) { return d.after_reset; };
    EXPECT_EQ(std::count_if(all_decisions_.begin(), all_decisions_.end(), reset), 1);
    EXPECT_TRUE(decisions().front().after_reset);
    EXPECT_EQ(decisions().front().time_us, world_->time_us(27));
    std::string text;
    for (const Decision& decision : all_decisions_) text += line_of(decision) + "\n";
    SequenceRunOptions measured = options();
    measured.measurements = measurements_of_all();
    for (const auto& file : {folder_.write("all.jsonl", text), live() / "decisions.jsonl"}) {
      measured.decisions = file;
      EXPECT_EQ(replay(measured), "");
      expect_same();
    }
  }
}

// One that does not know of the reset comes out otherwise, and says so.
TEST_F(ReplayTest, AResetThatIsNotRecordedDeparts) {
  run_live(InputMode::kNewest, 0, false, 27);
  std::string text;
  for (Decision decision : all_decisions_) {
    decision.after_reset = false;
    text += line_of(decision) + "\n";
  }
  SequenceRunOptions changed = options();
  changed.decisions = folder_.write("all.jsonl", text);
  EXPECT_NE(replay(changed).find("departs"), std::string::npos);
}

TEST_F(ReplayTest, AMeasurementThatIsMissingIsSaid) {
  run_live(InputMode::kNewest, 0, true);
  SequenceRunOptions measured = options();
  const std::string text = read_text(live() / "measurements.jsonl");
  const std::size_t second = text.find('\n', text.find('\n') + 1) + 1;
  measured.measurements = folder_.write("fewer.jsonl", text.substr(second));
  const std::string problem = replay(measured);
  EXPECT_NE(problem.find("fewer.jsonl: 2 of the "), std::string::npos) << problem;
}

// The measurements are given before the image that they were given before, not by their times.
TEST_F(ReplayTest, AMeasurementGivenAtAnotherImageDeparts) {
  run_live(InputMode::kNewest, 0, true);
  std::vector<Decision> made = decisions();
  auto last = made.rbegin();
  for (Decision& decision : made)
    if (&decision != &*last)
      last->measurements.insert(last->measurements.end(), decision.measurements.begin(),
                                decision.measurements.end()),
          decision.measurements.clear();
  std::string text;
  for (const Decision& decision : made) text += line_of(decision) + "\n";
  SequenceRunOptions measured = options();
  measured.decisions = folder_.write("late.jsonl", text);
  measured.measurements = live() / "measurements.jsonl";
  EXPECT_NE(replay(measured).find("departs"), std::string::npos);
}

TEST_F(ReplayTest, OtherSettingsDepart) {
  run_live(InputMode::kNewest);
  SequenceRunOptions changed = options();
  changed.mapper.landmark.neighbours = 2;
  const std::string problem = replay(changed);
  EXPECT_NE(problem.find("the replay departs from " + (live() / "decisions.jsonl").string()),
            std::string::npos)
      << problem;
  EXPECT_NE(read_text(again() / "trajectory.tum"), "") << "what came of it is there to be seen";
}

TEST_F(ReplayTest, AMissingImageIsSaid) {
  run_live(InputMode::kNewest);
  SequenceRunOptions missing = options();
  missing.sequence = folder_.path() / "fewer";
  record(folder_.path() / "fewer", [](int i) { return i != 40; });
  EXPECT_NE(replay(missing).find("1 of its 62 images are not in the sequence"), std::string::npos)
      << replay(missing);
  EXPECT_EQ(decisions().size(), 62u);
}

TEST_F(ReplayTest, AnImageThatIsNoneDeparts) {
  run_live(InputMode::kNewest);
  SequenceRunOptions broken = options();
  broken.sequence = folder_.path() / "broken";
  record(folder_.path() / "broken", [](int) { return true; });
  auto files = std::filesystem::directory_iterator(folder_.path() / "broken" / "images");
  std::vector<std::filesystem::path> images;
  for (const auto& file : files) images.push_back(file.path());
  std::sort(images.begin(), images.end());
  std::ofstream(images.at(40)) << "no image";
  EXPECT_NE(replay(broken).find("departs"), std::string::npos);
}

TEST_F(ReplayTest, ABadFileIsAProblemBeforeTheWork) {
  SequenceRunOptions bad = options();
  bad.decisions = folder_.write("d.jsonl", "{}\n");
  EXPECT_NE(replay(bad).find("d.jsonl line 1: "), std::string::npos);
}

// What the person at the terminal gets.
TEST_F(ReplayTest, TheProgramsExitCodeTells) {
  run_live(InputMode::kNewest);
  const auto exit_code = [this](const std::string& more) {
    const std::string command = std::string(EIFMAP_SERVER_BINARY) + " --sequence " +
                                recorded_->path().string() + " --output " + again().string() +
                                more + " 2> " + (folder_.path() / "said").string();
    return WEXITSTATUS(std::system(command.c_str()));
  };
  const std::string with = " --decisions " + (live() / "decisions.jsonl").string();
  EXPECT_EQ(exit_code(with), 0) << read_text(folder_.path() / "said");
  expect_same();
  EXPECT_EQ(exit_code(with + " --max-frames 9"), 2);
  EXPECT_NE(read_text(folder_.path() / "said").find("--max-frames"), std::string::npos);
  folder_.write("config.json", R"({"mapper": {"landmark": {"neighbours": 2}}})");
  EXPECT_EQ(exit_code(with + " --config " + (folder_.path() / "config.json").string()), 1);
  EXPECT_NE(read_text(folder_.path() / "said").find("the replay departs"), std::string::npos);
}

}  // namespace
}  // namespace eifmap
