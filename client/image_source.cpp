#include "client/image_source.h"

#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

class SimulatedSource : public ImageSource {
 public:
  explicit SimulatedSource(SimulatedWorld world) : world_(std::move(world)) {}

  std::string name() const override { return "courtyard"; }
  std::string kind() const override { return "simulated"; }
  int size() const override { return world_.num_frames(); }
  const Camera& camera() const override { return world_.camera(); }
  bool has(int i) override { return i < size(); }
  std::int64_t time_us(int i) override { return world_.time_us(i); }
  GrayImage gray(int i) override { return {world_.render(i), ""}; }

  std::vector<TumPose> ground_truth() override {
    std::vector<TumPose> poses;
    for (int i = 0; i < size(); ++i)
      poses.push_back({1e-6 * static_cast<double>(time_us(i)), world_.world_from_camera(i)});
    return poses;
  }

 private:
  SimulatedWorld world_;
};

class FirstImages : public DerivedSource {
 public:
  FirstImages(std::unique_ptr<ImageSource> source, int count)
      : DerivedSource(std::move(source)), size_(std::max(count, 0)) {
    if (source_->size() != kNoEnd) size_ = std::min(size_, source_->size());
  }

  int size() const override { return size_; }
  bool has(int i) override { return i < size_ && source_->has(i); }

  // The truth of the time that the images cover, or the path would be longer than the walk.
  std::vector<TumPose> ground_truth() override {
    std::vector<TumPose> poses = source_->ground_truth();
    if (size_ == 0 || poses.empty()) return {};
    const double end_s = 1e-6 * static_cast<double>(time_us(size_ - 1)) + 1e-6;
    std::erase_if(poses, [end_s](const TumPose& pose) { return pose.time_s > end_s; });
    return poses;
  }

 private:
  int size_;
};

class Looped : public DerivedSource {
 public:
  using DerivedSource::DerivedSource;

  int size() const override { return kNoEnd; }
  // There is one of the first pass only.
  std::vector<TumPose> ground_truth() override { return {}; }

  bool has(int i) override {
    if (count_ == 0 && source_->has(i)) {
      newest_ = i;
      return true;
    }
    if (count_ == 0) end_first_pass();
    return count_ > 0 && source_->has(i % count_);
  }

  std::int64_t time_us(int i) override {
    if (count_ == 0) return source_->time_us(i);
    return source_->time_us(i % count_) + i / count_ * pass_us_;
  }

  GrayImage gray(int i) override { return source_->gray(inner(i)); }
  std::optional<FileBytes> jpeg(int i) override { return source_->jpeg(inner(i)); }

 private:
  int inner(int i) const { return count_ == 0 ? i : i % count_; }

  // A pass takes as long as its images, and one more step from the last to the first.
  void end_first_pass() {
    count_ = newest_ + 1;
    if (count_ == 0) return;
    const std::int64_t last = source_->time_us(newest_), first = source_->time_us(0);
    constexpr std::int64_t kStepOfOneImage = 100'000;
    pass_us_ = count_ > 1 ? last - first + std::max<std::int64_t>(1, (last - first) / newest_)
                          : kStepOfOneImage;
  }

  int newest_ = -1;           // of the first pass
  int count_ = 0;             // images of a pass; 0: still in the first one
  std::int64_t pass_us_ = 0;  // length of a pass
};

}  // namespace

std::unique_ptr<ImageSource> make_source(SimulatedWorld world) {
  return std::make_unique<SimulatedSource>(std::move(world));
}

std::unique_ptr<ImageSource> first_images(std::unique_ptr<ImageSource> source, int count) {
  return std::make_unique<FirstImages>(std::move(source), count);
}

std::unique_ptr<ImageSource> looped(std::unique_ptr<ImageSource> source) {
  if (source->live()) return source;
  return std::make_unique<Looped>(std::move(source));
}

}  // namespace eifmap
