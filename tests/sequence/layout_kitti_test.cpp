// KITTI odometry: folders made here.
#include "sequence/layout_fixture.h"

namespace eifmap {
namespace {

class KittiTest : public test::LayoutTest {
 protected:
  KittiTest() {
    for (int i : {1, 0, 2})
      folder_.image("sequences/07/image_0/00000" + std::to_string(i) + ".png", 10 * i);
    folder_.write("sequences/07/times.txt", "0.000000e+00\n1.036224e-01\n2.070470e-01\n");
    folder_.write("sequences/07/calib.txt",
                  "P0: 70 0 31 0 0 71 23 0 0 0 1 0\nP1: 70 0 31 -35 0 71 23 0 0 0 1 0\n"
                  "P2: 70 0 31 21 0 71 23 7.1 0 0 1 0.1\n");
  }
  std::filesystem::path root() const override { return folder_.path() / "sequences" / "07"; }
};

TEST_F(KittiTest, ReadsASequenceWithItsPoses) {
  folder_.write("poses/07.txt",
                "1 0 0 0 0 1 0 0 0 0 1 0\n"
                "1 0 0 0.1 0 1 0 -0.2 0 0 1 0.3\n"
                "0 0 1 4 0 1 0 5 -1 0 0 6\n");
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  const RecordedSequence& sequence = *opened.sequence;
  EXPECT_EQ(sequence.layout(), "KITTI odometry");
  expect_grays(sequence, {0, 10, 20});
  EXPECT_EQ(sequence.time_us(1), 103622);
  EXPECT_EQ(sequence.camera().fx, 70);
  EXPECT_EQ(sequence.camera().fy, 71);
  EXPECT_EQ(sequence.camera().cx, 31);
  EXPECT_EQ(sequence.camera().cy, 23);
  EXPECT_EQ(sequence.camera().width, 64);
  EXPECT_EQ(sequence.camera().model, CameraModel::kPinhole);
  ASSERT_EQ(sequence.ground_truth().size(), 3u);
  EXPECT_NEAR(sequence.ground_truth()[2].time_s, 0.207047, 1e-6);
  const Rigid3& last = sequence.ground_truth()[2].world_from_camera;
  EXPECT_EQ(last.translation, Eigen::Vector3d(4, 5, 6));
  // Its x axis is the world's -z.
  EXPECT_LT((last.rotation * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST_F(KittiTest, PosesAreOfCamera0AlsoWhereTheColourImagesAreTaken) {
  std::filesystem::rename(root() / "image_0", root() / "image_2");
  folder_.write("sequences/07/poses.txt",
                "0 0 1 4 0 1 0 5 -1 0 0 6\n1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  // P2 = K [I | t]: t = ((21 - 31 * 0.1) / 70, (7.1 - 23 * 0.1) / 71, 0.1); the centre is at -t.
  const Eigen::Vector3d centre(-(21 - 3.1) / 70, -(7.1 - 2.3) / 71, -0.1);
  ASSERT_EQ(opened.sequence->ground_truth().size(), 3u);
  EXPECT_LT((opened.sequence->ground_truth()[1].world_from_camera.translation - centre).norm(),
            1e-12);
  const Eigen::Vector3d turned(4 + centre.z(), 5 + centre.y(), 6 - centre.x());
  EXPECT_LT((opened.sequence->ground_truth()[0].world_from_camera.translation - turned).norm(),
            1e-12);
  // A calibration of one's own moves no camera.
  SequenceOptions options;
  options.calibration = folder_.write(
      "mine.json", R"({"width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 32, "cy": 24})");
  const auto calibrated = open(options);
  ASSERT_EQ(calibrated.problem, "");
  EXPECT_EQ(calibrated.sequence->camera().fx, 60);
  EXPECT_LT((calibrated.sequence->ground_truth()[0].world_from_camera.translation - turned).norm(),
            1e-12);
}

TEST_F(KittiTest, ABadCalibrationFileMayBeReplaced) {
  folder_.write("sequences/07/poses.txt",
                "1 0 0 4 0 1 0 5 0 0 1 6\n1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  SequenceOptions options;
  options.calibration = folder_.write(
      "mine.json", R"({"width": 64, "height": 48, "fx": 60, "fy": 60, "cx": 32, "cy": 24})");
  for (const char* text : {"none\n", "P0: 0 0 31 0 0 0 23 0 0 0 1 0\n"}) {
    folder_.write("sequences/07/calib.txt", text);
    const auto opened = open(options);
    ASSERT_EQ(opened.problem, "") << text;
    EXPECT_EQ(opened.sequence->ground_truth()[0].world_from_camera.translation,
              Eigen::Vector3d(4, 5, 6));
  }
}

TEST_F(KittiTest, SaysWhichFileAndLineIsWrong) {
  folder_.write("sequences/07/times.txt", "0\n0.1\n");
  expect_problem({"times.txt: has 2 times for 3 images"});
  folder_.write("sequences/07/times.txt", "0\n0.1\nlater\n");
  expect_problem({"times.txt line 3: 'later' is no time"});
  folder_.write("sequences/07/times.txt", "0\n0.1\n0.2\n");
  folder_.write("poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1\n");
  expect_problem({"07.txt line 2: has 11 words; wanted 12"});
  folder_.write("poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n5 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_problem({"07.txt line 2: is no pose"});
  folder_.write("poses/07.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_problem({"07.txt: has 1 poses for 3 images"});
  std::filesystem::remove(folder_.path() / "poses/07.txt");
  folder_.write("sequences/07/calib.txt", "P0: 70 0 31 0 0 seventy 23 0 0 0 1 0\n");
  expect_problem({"calib.txt line 1: 'seventy' is no finite number"});
  folder_.write("sequences/07/calib.txt", "P1: 70 0 31 0 0 71 23 0 0 0 1 0\n");
  expect_problem({"calib.txt: has no line 'P0:'"});
  folder_.write("sequences/07/calib.txt", "P0: -70 0 31 0 0 71 23 0 0 0 1 0\n");
  expect_problem({"calib.txt: camera: fx is -70"});
  std::filesystem::remove(root() / "calib.txt");
  expect_problem({"has no calibration", "--calib FILE", "--hfov DEGREES"});
  std::filesystem::remove(root() / "times.txt");
  expect_problem({"times.txt: cannot be read"});
}

}  // namespace
}  // namespace eifmap
