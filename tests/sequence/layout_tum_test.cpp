// TUM RGB-D: folders made here.
#include "sequence/layout_fixture.h"

namespace eifmap {
namespace {

class TumTest : public test::LayoutTest {
 protected:
  TumTest() {
    for (int i = 0; i < 2; ++i)
      folder_.image(kName + "/rgb/130503110" + std::to_string(i) + ".5.png", 10 + i, 640, 480);
    folder_.write(kName + "/rgb.txt",
                  "# color images\n# file: 'a.bag'\n# timestamp filename\n"
                  "1305031100.500004 rgb/1305031100.5.png\n"
                  "1305031101.500006 rgb/1305031101.5.png\n");
  }
  std::filesystem::path root() const override { return folder_.path() / kName; }

  const std::string kName = "rgbd_dataset_freiburg1_xyz";
};

TEST_F(TumTest, ReadsTheListTheTruthAndTheKnownCamera) {
  folder_.write(kName + "/groundtruth.txt",
                "# timestamp tx ty tz qx qy qz qw\n1305031100.4 1 2 3 0 0 0 1\n");
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  const RecordedSequence& sequence = *opened.sequence;
  EXPECT_EQ(sequence.layout(), "TUM RGB-D");
  expect_grays(sequence, {10, 11});
  EXPECT_EQ(sequence.time_us(0), 1305031100500004);
  EXPECT_EQ(sequence.time_us(1), 1305031101500006);
  EXPECT_EQ(sequence.camera().fx, 517.3);
  EXPECT_EQ(sequence.camera().cy, 255.3);
  EXPECT_EQ(sequence.camera().distortion[4], 1.1633);
  EXPECT_EQ(sequence.camera().model, CameraModel::kRadialTangential);
  ASSERT_EQ(sequence.ground_truth().size(), 1u);
  EXPECT_EQ(sequence.ground_truth()[0].world_from_camera.translation, Eigen::Vector3d(1, 2, 3));
}

TEST_F(TumTest, TheFoldersNameTellsTheCamera) {
  const auto fx_of = [this](const std::string& name) {
    const auto to = folder_.path() / name;
    std::filesystem::rename(root(), to);
    const auto opened = RecordedSequence::open(to);
    std::filesystem::rename(to, root());
    return opened.sequence ? opened.sequence->camera().fx : 0;
  };
  EXPECT_EQ(fx_of("rgbd_dataset_freiburg2_desk"), 520.9);
  EXPECT_EQ(fx_of("run_fr3"), 0) << "nobody says that it is theirs";
  EXPECT_EQ(fx_of("my_desk"), 0);
}

TEST_F(TumTest, WhatIsNamedOtherwiseWantsACalibration) {
  std::filesystem::rename(root(), folder_.path() / "desk");
  const auto desk = folder_.path() / "desk";
  const auto without = RecordedSequence::open(desk);
  EXPECT_NE(without.problem.find("has no calibration; give it by --calib FILE"), std::string::npos)
      << without.problem;
  SequenceOptions options;
  options.calibration = folder_.write(
      "mine.json", R"({"width": 640, "height": 480, "fx": 500, "fy": 500, "cx": 320, "cy": 240})");
  const auto with = RecordedSequence::open(desk, options);
  ASSERT_EQ(with.problem, "");
  EXPECT_EQ(with.sequence->camera().fx, 500);
}

// It goes before the recording's own.
TEST_F(TumTest, ACalibrationFileIsUsedInAnyCase) {
  SequenceOptions options;
  options.calibration = folder_.write(
      "mine.json", R"({"width": 640, "height": 480, "fx": 500, "fy": 500, "cx": 320, "cy": 240})");
  EXPECT_EQ(open(options).sequence->camera().fx, 500);
  expect_problem({"--hfov would put a guess in the place of"}, hfov(60));
}

TEST_F(TumTest, SaysWhichFileAndLineIsWrong) {
  const auto list = [this](const std::string& text) { folder_.write(kName + "/rgb.txt", text); };
  list("# t\n1305031100.5 rgb/1305031100.5.png\n1305031100.5 rgb/1305031101.5.png\n");
  expect_problem({"rgb.txt line 3: 1305031100.5 s is not after the time before it"});
  list("1305031100.5 rgb/gone.png\n");
  expect_problem({"rgb.txt line 1: ", "rgb/gone.png is not there"});
  list("1305031100.5\n");
  expect_problem({"rgb.txt line 1: '1305031100.5' alone"});
  list("noon rgb/1305031100.5.png\n");
  expect_problem({"rgb.txt line 1: 'noon' is no time"});
  list("# nothing\n");
  expect_problem({"rgb.txt: lists no images"});
  list("1305031100.5 rgb/1305031100.5.png\n");
  folder_.write(kName + "/groundtruth.txt", "1 2 3 4 5 6 seven 8\n");
  expect_problem({"groundtruth.txt line 1: 'seven' is no number"});
  std::filesystem::remove(root() / "rgb.txt");
  expect_problem({"rgb.txt: cannot be read"});
}

}  // namespace
}  // namespace eifmap
