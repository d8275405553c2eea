#include "server/sequence_run.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

// A recorded folder of a few textured images.
void record(const TemporaryFolder& folder, int frames) {
  folder.write("calib.json", R"({"width":320,"height":240,"fx":250,"fy":250,"cx":159.5,"cy":119.5,)"
                             R"("distortion":[0,0,0,0,0]})");
  cv::Mat texture(240, 640, CV_8UC1);
  cv::RNG(1).fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, {0, 0}, 2);
  std::string times;
  std::filesystem::create_directories(folder.path() / "images");
  for (int i = 0; i < frames; ++i) {
    times += std::to_string(0.1 * i) + "\n";
    cv::imwrite((folder.path() / "images" / ("00" + std::to_string(10 + i) + ".png")).string(),
                texture.colRange(4 * i, 4 * i + 320));
  }
  folder.write("times.txt", times);
}

std::string run(const SequenceRunOptions& options) {
  return run_sequence(options, [](int, int) { return true; });
}

nlohmann::json report(const SequenceRunOptions& options) {
  return nlohmann::json::parse(read_text(options.output / "report.json"));
}

TEST(SequenceRun, WritesEveryFileAndEveryFigure) {
  const TemporaryFolder folder;
  record(folder, 6);
  SequenceRunOptions options;
  options.sequence = folder.path();
  options.output = folder.path() / "out" / "deep";
  int last_done = -1, last_total = -1;
  ASSERT_EQ(run_sequence(options,
                         [&](int done, int total) {
                           EXPECT_GE(done, last_done);
                           last_done = done;
                           last_total = total;
                           return true;
                         }),
            "");
  EXPECT_EQ(last_done, 6);
  EXPECT_EQ(last_total, 6);
  for (const char* file : {"trajectory.tum", "trajectory_final.tum", "keyframes.tum", "map.ply"})
    EXPECT_TRUE(std::filesystem::exists(options.output / file)) << file;
  const nlohmann::json json = report(options);
  for (const char* key : {"frames", "tracked", "coverage", "keyframes", "landmarks", "edges",
                          "starts", "losses", "moving_matches", "nis", "rolls_unseen",
                          "pose_sources", "reasons", "cpu_s", "wall_s", "peak_rss_mib", "steps"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["frames"], 6);
  for (const char* step : {"decode", "extract", "frame"}) {
    EXPECT_EQ(json["steps"][step]["frames"], 6) << step;
    EXPECT_GE(json["steps"][step]["p99_ms"], json["steps"][step]["median_ms"]);
  }
}

// The same images in another layout are the same map.
TEST(SequenceRun, ImagesAloneAreMappedAsOurOwn) {
  const TemporaryFolder folder, plain;
  record(folder, 6);
  std::filesystem::copy(folder.path() / "images", plain.path());
  SequenceRunOptions options;
  options.sequence = folder.path();
  options.output = folder.path() / "own";
  ASSERT_EQ(run(options), "");
  options.sequence = plain.path();
  options.output = folder.path() / "plain";
  EXPECT_NE(run(options).find("has no calibration"), std::string::npos);
  options.images.calibration = folder.path() / "calib.json";
  std::vector<std::string> notes;
  ASSERT_EQ(run_sequence(
                options, [](int, int) { return true; },
                [&notes](const std::string& note) { notes.push_back(note); }),
            "");
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("10 images a second are assumed"), std::string::npos);
  for (const char* file : {"trajectory.tum", "trajectory_final.tum", "keyframes.tum", "map.ply"})
    EXPECT_EQ(read_text(folder.path() / "own" / file), read_text(folder.path() / "plain" / file))
        << file;
  EXPECT_NE(read_text(folder.path() / "plain" / "map.ply"), "");
}

TEST(SequenceRun, EveryAndMaxFramesAndAnEarlyStop) {
  const TemporaryFolder folder;
  record(folder, 7);
  SequenceRunOptions options;
  options.sequence = folder.path();
  options.output = folder.path() / "out";
  options.every = 3;
  ASSERT_EQ(run(options), "");
  EXPECT_EQ(report(options)["frames"], 3);
  options.max_frames = 2;
  ASSERT_EQ(run(options), "");
  EXPECT_EQ(report(options)["frames"], 2);
  options = {options.sequence, options.output, 1, 0, 0, 1, {}, {}, {}};
  ASSERT_EQ(run_sequence(options, [](int done, int) { return done < 4; }), "");
  EXPECT_EQ(report(options)["frames"], 4) << "what there is by then is written";
}

TEST(SequenceRun, AnUnreadableImageIsCountedAndPassedOver) {
  const TemporaryFolder folder;
  record(folder, 4);
  folder.write("images/0011.png", "no image");
  SequenceRunOptions options;
  options.sequence = folder.path();
  options.output = folder.path() / "out";
  ASSERT_EQ(run(options), "");
  EXPECT_EQ(report(options)["frames"], 4);
  EXPECT_EQ(report(options)["rejected_reasons"]["CORRUPT_IMAGE"], 1);
}

TEST(SequenceRun, NoUsableImageIsAProblem) {
  const TemporaryFolder folder;
  record(folder, 2);
  folder.write("images/0010.png", "no image");
  folder.write("images/0011.png", "no image");
  SequenceRunOptions options;
  options.sequence = folder.path();
  options.output = folder.path() / "out";
  const std::string problem = run(options);
  EXPECT_NE(problem.find("none of the 2 images could be used: "), std::string::npos) << problem;
  EXPECT_NE(problem.find("0010.png: cannot be decoded"), std::string::npos) << problem;
}

TEST(SequenceRun, ProblemsAreSentencesAndMisuseThrows) {
  SequenceRunOptions options;
  options.sequence = "/nowhere";
  EXPECT_NE(run(options).find("/nowhere"), std::string::npos);
  options.every = 0;
  EXPECT_THROW(run(options), std::invalid_argument);
  const TemporaryFolder folder;
  record(folder, 2);
  const auto file = folder.write("file", "");
  options = {folder.path(), file / "out", 1, 0, 0, 1, {}, {}, {}};
  EXPECT_NE(run(options).find("file"), std::string::npos) << "an output that cannot be made";
}

}  // namespace
}  // namespace eifmap
