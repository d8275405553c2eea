// Whole folders, read again by eifmap's own reader.
#include <gtest/gtest.h>

#include <map>
#include <opencv2/imgcodecs.hpp>

#include "robustness/corruption.h"
#include "robustness/degradation.h"
#include "robustness/effects.h"
#include "sequence/temporary_folder.h"
#include "simulation/simulated_world.h"

namespace eifmap::test {
namespace {

constexpr int kFrames = 40;

class Folders : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    source_folder_ = std::make_unique<TemporaryFolder>();
    SimulationOptions options;
    options.distorted = true;
    const SimulatedWorld world(options);
    OwnFolder folder(source_folder_->path() / "source");
    const cv::Mat image = world.render(0);
    std::vector<TimedPose> truth;
    for (int i = 0; i < kFrames; ++i) {
      folder.add(world.time_us(i), with_gain(image, 1 - 0.01 * i));
      truth.push_back({world.time_us(i), world.world_from_camera(i)});
    }
    folder.finish(world.camera(), truth);
    source_ = open(source_folder_->path() / "source");
  }
  static void TearDownTestSuite() {
    source_.reset();
    source_folder_.reset();
  }

  static std::optional<RecordedSequence> open(const std::filesystem::path& folder) {
    auto opened = RecordedSequence::open(folder);
    EXPECT_EQ(opened.problem, "");
    return opened.sequence;
  }

  RecordedSequence degraded(const std::string& name, std::uint64_t seed,
                            const std::string& to = "degraded") {
    for (const Degradation& each : all_degradations()) {
      if (each.name != name) continue;
      Random random(seed);
      OwnFolder folder(folder_.path() / to);
      each.write(*source_, random, folder);
    }
    return open(folder_.path() / to).value();
  }

  static std::unique_ptr<TemporaryFolder> source_folder_;
  static std::optional<RecordedSequence> source_;
  TemporaryFolder folder_;
};
std::unique_ptr<TemporaryFolder> Folders::source_folder_;
std::optional<RecordedSequence> Folders::source_;

double difference(const GrayImage& a, const GrayImage& b) {
  EXPECT_EQ(a.problem + b.problem, "");
  return cv::norm(a.image, b.image, cv::NORM_INF);
}

TEST_F(Folders, AsRecordedIsTheSame) {
  const RecordedSequence copy = degraded("as_recorded", 1);
  ASSERT_EQ(copy.size(), kFrames);
  EXPECT_EQ(copy.camera().id(), source_->camera().id());
  ASSERT_EQ(copy.ground_truth().size(), source_->ground_truth().size());
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(copy.time_us(i), source_->time_us(i));
    EXPECT_EQ(difference(copy.load_gray(i), source_->load_gray(i)), 0);
    const Rigid3 &a = copy.ground_truth()[i].world_from_camera,
                 &b = source_->ground_truth()[i].world_from_camera;
    EXPECT_EQ(a.translation, b.translation);
  }
}

TEST_F(Folders, AFisheyeStaysOne) {
  Camera fisheye = source_->camera();
  fisheye.model = CameraModel::kFisheye;
  fisheye.distortion = {0.01, -0.02, 0.003, -0.0004, 0};
  OwnFolder folder(folder_.path() / "fisheye");
  folder.add_link(0, source_->image_file(0));
  folder.finish(fisheye, {});
  const RecordedSequence copy = open(folder_.path() / "fisheye").value();
  EXPECT_EQ(copy.camera().id(), fisheye.id());
  EXPECT_TRUE(copy.ground_truth().empty());
}

TEST_F(Folders, HalfTheSizeHasHalfTheCamera) {
  const RecordedSequence half = degraded("half_size", 1);
  ASSERT_EQ(half.size(), kFrames);
  EXPECT_EQ(half.camera().id(), half_size(source_->camera()).id());
  EXPECT_EQ(half.load_gray(3).problem, "");
}

TEST_F(Folders, HalfTheRateIsEverySecond) {
  const RecordedSequence half = degraded("half_rate", 1);
  ASSERT_EQ(half.size(), kFrames / 2);
  for (int i = 0; i < half.size(); ++i) {
    EXPECT_EQ(half.time_us(i), source_->time_us(2 * i));
    EXPECT_EQ(difference(half.load_gray(i), source_->load_gray(2 * i)), 0);
  }
}

TEST_F(Folders, BurstsAreGone) {
  const RecordedSequence rest = degraded("bursts", 1);
  EXPECT_EQ(rest.size(), kFrames - kFrames / 10);
}

TEST_F(Folders, EachDegradationChangesTheImagesAsItSays) {
  const std::map<std::string, std::pair<double, double>> largest{
      {"jpeg80", {1, 60}}, {"jpeg50", {1, 100}}, {"noise", {35, 80}}};
  for (const auto& [name, range] : largest) {
    const RecordedSequence changed = degraded(name, 1, name);
    ASSERT_EQ(changed.size(), kFrames);
    const double change = difference(changed.load_gray(5), source_->load_gray(5));
    EXPECT_GE(change, range.first) << name;
    EXPECT_LE(change, range.second) << name;
  }
  const RecordedSequence exposed = degraded("gain", 1, "gain");
  EXPECT_EQ(difference(exposed.load_gray(0), source_->load_gray(0)), 0);
  EXPECT_GT(difference(exposed.load_gray(31), source_->load_gray(31)) +
                difference(exposed.load_gray(11), source_->load_gray(11)),
            10);
}

// What says that it needs no seeds is the same with all of them, what does not is another.
TEST_F(Folders, TheSeedDecides) {
  const auto contents = [&](const Degradation& each, std::uint64_t seed, const std::string& run) {
    const RecordedSequence result = degraded(each.name, seed, each.name + run);
    std::string all;
    for (int i = 0; i < result.size(); ++i) {
      all += std::to_string(result.time_us(i)) + ' ';
      const FileBytes bytes = result.load_bytes(i);
      all.append(bytes.bytes.begin(), bytes.bytes.end());
    }
    return all;
  };
  for (const Degradation& each : all_degradations()) {
    const std::string one = contents(each, 1, "one");
    EXPECT_TRUE(one == contents(each, 1, "again")) << each.name;
    EXPECT_EQ(one != contents(each, 2, "two"), each.random) << each.name;
  }
}

TEST_F(Folders, AFolderWithImagesIsLeftAlone) {
  degraded("as_recorded", 1);
  EXPECT_THROW(OwnFolder(folder_.path() / "degraded"), std::runtime_error);
}

std::vector<Corruption> every_kind() {
  std::vector<Corruption> kinds;
  for (const CorruptionName& each : all_corruptions()) kinds.push_back(each.kind);
  return kinds;
}

TEST_F(Folders, StrangeImagesComeBetweenTheGoodOnes) {
  Random random(5);
  OwnFolder folder(folder_.path() / "strange");
  const int good = 30, strange = 60;
  const std::vector<Corrupted> put_in =
      write_corrupted(*source_, good, strange, every_kind(), random, folder);
  ASSERT_EQ(put_in.size(), 60u);
  const RecordedSequence all = open(folder_.path() / "strange").value();
  ASSERT_EQ(all.size(), good + strange);
  EXPECT_EQ(all.camera().id(), source_->camera().id());
  std::map<std::int64_t, Corruption> kind_at;
  for (const Corrupted& each : put_in) kind_at[each.time_us] = each.kind;
  ASSERT_EQ(kind_at.size(), 60u) << "no two at a time";
  int clean = 0;
  std::map<Corruption, int> kinds;
  for (int i = 0; i < all.size(); ++i) {
    const GrayImage image = all.load_gray(i);
    const auto found = kind_at.find(all.time_us(i));
    if (found == kind_at.end()) {
      ASSERT_EQ(all.time_us(i), source_->time_us(clean));
      ASSERT_EQ(difference(image, source_->load_gray(clean++)), 0);
      continue;
    }
    ++kinds[found->second];
    if (found->second == Corruption::kWrongSize) {
      EXPECT_NE(image.problem.find("must have the calibration's size"), std::string::npos);
      continue;
    }
    EXPECT_GT(difference(image, source_->load_gray(clean - 1)), 50);
    EXPECT_EQ(cv::countNonZero(image.image) == 0, found->second == Corruption::kBlack);
  }
  EXPECT_EQ(clean, good);
  for (const Corruption kind : every_kind()) EXPECT_GE(kinds[kind], 3) << static_cast<int>(kind);
}

}  // namespace
}  // namespace eifmap::test
