#include "sequence/image_source.h"

#include <utility>

namespace eifmap {
namespace {

class RecordedSource : public ImageSource {
 public:
  explicit RecordedSource(RecordedSequence sequence) : sequence_(std::move(sequence)) {}

  std::string name() const override { return last_name(sequence_.folder()); }
  std::string kind() const override { return sequence_.layout(); }
  int size() const override { return sequence_.size(); }
  const Camera& camera() const override { return sequence_.camera(); }
  std::vector<TumPose> ground_truth() override { return sequence_.ground_truth(); }
  std::vector<std::string> notes() const override { return sequence_.notes(); }
  bool has(int i) override { return i < sequence_.size(); }
  std::int64_t time_us(int i) override { return sequence_.time_us(i); }
  GrayImage gray(int i) override { return sequence_.load_gray(i); }

  std::optional<FileBytes> jpeg(int i) override {
    const auto extension = sequence_.image_file(i).extension();
    if (extension != ".jpg" && extension != ".jpeg") return std::nullopt;
    return sequence_.load_bytes(i);
  }

 private:
  RecordedSequence sequence_;
};

}  // namespace

std::unique_ptr<ImageSource> make_source(RecordedSequence sequence) {
  return std::make_unique<RecordedSource>(std::move(sequence));
}

std::string last_name(const std::filesystem::path& path) {
  const auto normal = path.lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).filename().string();
}

}  // namespace eifmap
