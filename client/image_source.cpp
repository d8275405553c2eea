#include "client/image_source.h"

#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

class RecordedSource : public ImageSource {
 public:
  explicit RecordedSource(RecordedSequence sequence) : sequence_(std::move(sequence)) {}

  std::string name() const override {
    const auto folder = sequence_.folder().lexically_normal();
    return (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  }
  int size() const override { return sequence_.size(); }
  const Camera& camera() const override { return sequence_.camera(); }
  std::vector<TumPose> ground_truth() const override { return sequence_.ground_truth(); }
  std::int64_t time_us(int i) const override { return sequence_.time_us(i); }
  GrayImage gray(int i) const override { return sequence_.load_gray(i); }

  std::optional<FileBytes> jpeg(int i) const override {
    const auto extension = sequence_.image_file(i).extension();
    if (extension != ".jpg" && extension != ".jpeg") return std::nullopt;
    return sequence_.load_bytes(i);
  }

 private:
  RecordedSequence sequence_;
};

class SimulatedSource : public ImageSource {
 public:
  explicit SimulatedSource(SimulatedWorld world) : world_(std::move(world)) {}

  std::string name() const override { return "courtyard"; }
  int size() const override { return world_.num_frames(); }
  const Camera& camera() const override { return world_.camera(); }
  std::int64_t time_us(int i) const override { return world_.time_us(i); }
  GrayImage gray(int i) const override { return {world_.render(i), ""}; }
  std::optional<FileBytes> jpeg(int) const override { return std::nullopt; }

  std::vector<TumPose> ground_truth() const override {
    std::vector<TumPose> poses;
    for (int i = 0; i < size(); ++i)
      poses.push_back({1e-6 * static_cast<double>(time_us(i)), world_.world_from_camera(i)});
    return poses;
  }

 private:
  SimulatedWorld world_;
};

class FirstImages : public ImageSource {
 public:
  FirstImages(std::unique_ptr<ImageSource> source, int count)
      : source_(std::move(source)), size_(std::clamp(count, 0, source_->size())) {}

  std::string name() const override { return source_->name(); }
  int size() const override { return size_; }
  const Camera& camera() const override { return source_->camera(); }
  std::int64_t time_us(int i) const override { return source_->time_us(i); }
  GrayImage gray(int i) const override { return source_->gray(i); }
  std::optional<FileBytes> jpeg(int i) const override { return source_->jpeg(i); }

  // The truth of the time that the images cover, or the path would be longer than the walk.
  std::vector<TumPose> ground_truth() const override {
    std::vector<TumPose> poses = source_->ground_truth();
    if (size_ == 0) return {};
    const double end_s = 1e-6 * static_cast<double>(time_us(size_ - 1)) + 1e-6;
    std::erase_if(poses, [end_s](const TumPose& pose) { return pose.time_s > end_s; });
    return poses;
  }

 private:
  std::unique_ptr<ImageSource> source_;
  int size_;
};

}  // namespace

std::unique_ptr<ImageSource> make_source(RecordedSequence sequence) {
  return std::make_unique<RecordedSource>(std::move(sequence));
}

std::unique_ptr<ImageSource> make_source(SimulatedWorld world) {
  return std::make_unique<SimulatedSource>(std::move(world));
}

std::unique_ptr<ImageSource> first_images(std::unique_ptr<ImageSource> source, int count) {
  return std::make_unique<FirstImages>(std::move(source), count);
}

}  // namespace eifmap
