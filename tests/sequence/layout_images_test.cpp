// Images alone, and folders that are none of the known ones: folders made here.
#include "sequence/layout_fixture.h"

namespace eifmap {
namespace {

class ImagesTest : public test::LayoutTest {
 protected:
  ImagesTest() {
    folder_.image("shot10.png", 30);
    folder_.image("shot2.pgm", 20);
    folder_.image("shot1.PNG", 10);
    folder_.write("notes.txt", "no image");
  }
};

TEST_F(ImagesTest, NaturalOrderAndAGuessThatSaysSo) {
  const auto opened = open(hfov(90));
  ASSERT_EQ(opened.problem, "");
  const RecordedSequence& sequence = *opened.sequence;
  EXPECT_EQ(sequence.layout(), "plain");
  expect_grays(sequence, {10, 20, 30});
  EXPECT_EQ(sequence.time_us(0), 0);
  EXPECT_EQ(sequence.time_us(2), 200000);
  EXPECT_EQ(sequence.camera().model, CameraModel::kPinhole);
  EXPECT_NEAR(sequence.camera().fx, 32, 1e-12);  // 90 degrees: half the width
  EXPECT_NEAR(sequence.camera().fy, 32, 1e-12);
  EXPECT_EQ(sequence.camera().cx, 31.5);
  EXPECT_EQ(sequence.camera().cy, 23.5);
  ASSERT_EQ(sequence.notes().size(), 2u);
  EXPECT_NE(sequence.notes()[0].find("10 images a second are assumed; --rate HZ"),
            std::string::npos);
  EXPECT_NE(sequence.notes()[1].find("calibration is GUESSED: a pinhole of f = 32.0 px"),
            std::string::npos);
}

TEST_F(ImagesTest, TheRateIsTheUsers) {
  SequenceOptions options = hfov(60);
  options.rate_hz = 30;
  const auto opened = open(options);
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.sequence->time_us(1), 33333);
  EXPECT_EQ(opened.sequence->time_us(2), 66667);
  EXPECT_EQ(opened.sequence->notes().size(), 1u);
}

TEST_F(ImagesTest, ACalibrationBesideThemIsTheirs) {
  folder_.write("calib.json",
                R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 32, "cy": 24})");
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.sequence->camera().fx, 50);
  expect_problem({"--hfov would put a guess in the place of calib.json"}, hfov(60));
  folder_.write("calib.json", "{\n\"width\": 64,,\n");
  expect_problem({"calib.json line 2: is no JSON"});
}

TEST_F(ImagesTest, SaysWhichOptionsHelp) {
  expect_problem({"has no calibration", "--calib FILE", "--hfov DEGREES"});
  SequenceOptions options;
  options.calibration = folder_.write(
      "other.json", R"({"width": 640, "height": 480, "fx": 500, "fy": 500, "cx": 320, "cy": 240})");
  expect_problem({"the images are 64x48, but ", "other.json says 640x480", "--calib FILE"},
                 options);
  options.calibration = folder_.path() / "none.json";
  expect_problem({"none.json: cannot be read"}, options);
  options.hfov_deg = 60;
  EXPECT_THROW(open(options), std::invalid_argument);
  EXPECT_THROW(open(hfov(170)), std::invalid_argument);
  folder_.write("shot1.PNG", "broken");
  expect_problem({"the first image cannot be read, and --hfov needs its size"}, hfov(60));
}

TEST(Layout, AnEmptyOrStrangeFolderSaysWhatIsWanted) {
  const TemporaryFolder folder;
  const auto problem = [&] { return RecordedSequence::open(folder.path()).problem; };
  EXPECT_NE(
      problem().find("is empty; wanted a folder that holds images/, times.txt and calib.json"),
      std::string::npos)
      << problem();
  folder.write("readme.md", "nothing here");
  EXPECT_NE(problem().find("holds no images in a known layout; wanted images/"), std::string::npos);
  for (const char* name : {"KITTI", "TUM RGB-D", "EuRoC", "images alone"})
    EXPECT_NE(problem().find(name), std::string::npos) << name;
}

// Only what is missing is assumed.
TEST(Layout, OurOwnWithoutTimesOrCalibration) {
  const test::ImageFolder folder;
  folder.image("images/a2.png", 1);
  folder.image("images/a10.png", 2);
  SequenceOptions options;
  EXPECT_NE(RecordedSequence::open(folder.path()).problem.find("or their rate by --rate HZ"),
            std::string::npos);
  options.rate_hz = 5;
  EXPECT_NE(RecordedSequence::open(folder.path(), options).problem.find("has no calibration"),
            std::string::npos);
  options.hfov_deg = 60;
  const auto opened = RecordedSequence::open(folder.path(), options);
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.sequence->time_us(1), 200000);
  // In the order of the names' bytes, as ever.
  EXPECT_EQ(opened.sequence->image_file(0).filename(), "a10.png");
}

}  // namespace
}  // namespace eifmap
