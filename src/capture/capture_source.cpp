#include "capture/capture_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "sequence/camera_choice.h"

namespace eifmap {
namespace {

// OpenCV and FFmpeg tell standard error what a caller is told by a result.
class Quiet {
 public:
  Quiet() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {
    static std::once_flag once;
    std::call_once(once, [] { setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0); });
  }
  ~Quiet() { cv::utils::logging::setLogLevel(before_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

std::int64_t now_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

bool open_any(cv::VideoCapture& capture, const std::string& name, bool live) {
  const Quiet quiet;
  const auto opens = [&](int backend) {
    try {
      return capture.open(name, backend);
    } catch (const cv::Exception&) {
      return false;
    }
  };
  if (live) {
    if (!opens(cv::CAP_V4L2)) return false;
    capture.set(cv::CAP_PROP_BUFFERSIZE, 1);  // else what waits in it arrives late
    return true;
  }
  // The one backend by name: others take a file's name as a pattern, start services, or print.
  if (!opens(cv::CAP_FFMPEG)) return false;
  // The calibration is of the pixels as stored: a rotation tag must not turn them.
  capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  return true;
}

class CaptureSource : public ImageSource {
 public:
  CaptureSource(std::filesystem::path path, bool live) : path_(std::move(path)), live_(live) {}

  // Returns "" or what is wrong.
  std::string open(const SequenceOptions& options) {
    if (!open_any(capture_, path_.string(), live_)) return cannot_open();
    const double count = live_ ? 0 : capture_.get(cv::CAP_PROP_FRAME_COUNT);
    if (count >= 1 && count < 1e9) size_ = static_cast<int>(count);
    set_period(options);
    if (!has(0))
      return path_.string() + ": gives no image; " +
             (live_ ? "is another program using it?" : "is the file whole?");
    const GrayImage first = gray(0);
    if (!first.problem.empty()) return first.problem;
    CameraChoice choice =
        choose_camera(options, path_.string(), std::nullopt, "", first.image.size());
    camera_ = choice.camera;
    if (!choice.note.empty()) notes_.push_back(choice.note);
    return choice.problem;
  }

  std::string name() const override { return last_name(path_); }
  std::string kind() const override { return live_ ? "camera" : "video"; }
  bool live() const override { return live_; }
  const Camera& camera() const override { return camera_; }
  std::vector<std::string> notes() const override { return notes_; }
  std::string problem() const override { return problem_; }

  int size() const override { return size_; }

  bool has(int i) override { return go_to(i); }

  std::int64_t time_us(int i) override {
    go_to(i);
    return time_us_;
  }

  GrayImage gray(int i) override {
    const Quiet quiet;
    cv::Mat image;
    try {
      if (!go_to(i) || !capture_.retrieve(image) || image.empty()) return undecoded(i);
      if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
    } catch (const cv::Exception&) {
      return undecoded(i);
    }
    if (image.type() != CV_8UC1) return undecoded(i);
    return {image.clone(), ""};
  }

 private:
  std::string cannot_open() const {
    if (!live_)
      return path_.string() +
             ": cannot be opened as a video; give a folder of images, or a video that FFmpeg reads";
    std::error_code error;
    if (!std::filesystem::exists(path_, error))
      return path_.string() + ": there is no such camera; ls /dev/video* shows those there are";
    return path_.string() +
           ": cannot be opened as a camera; is another program using it, and may you read it?";
  }

  GrayImage undecoded(int i) const {
    return {{}, path_.string() + ": image " + std::to_string(i) + " cannot be decoded"};
  }

  void set_period(const SequenceOptions& options) {
    if (live_) return;
    const double rate = capture_.get(cv::CAP_PROP_FPS);
    const bool known = rate > 0 && rate <= 10000;
    const double used = known ? rate : options.rate_hz > 0 ? options.rate_hz : 10;
    period_us_ = std::max<std::int64_t>(1, std::llround(1e6 / used));
    if (known || options.rate_hz > 0) return;
    notes_.push_back(path_.string() +
                     " says no rate: where it has no times either, 10 images a second are assumed; "
                     "--rate HZ says otherwise");
  }

  // Grabs until image i is the one at hand. False at the end.
  bool go_to(int i) {
    if (i < at_) {
      if (live_ || !open_any(capture_, path_.string(), live_)) return false;
      at_ = -1;
      ended_ = false;
    }
    const Quiet quiet;
    while (at_ < i && !ended_) {
      if (!capture_.grab()) {
        ended_ = true;
        if (live_) problem_ = path_.string() + ": gives no more images; is it still plugged in?";
        return false;
      }
      ++at_;
      set_time();
    }
    return at_ == i;
  }

  void set_time() {
    const std::int64_t before = time_us_;
    time_us_ = live_ ? now_us() : std::llround(1000 * capture_.get(cv::CAP_PROP_POS_MSEC));
    if (at_ > 0 && time_us_ <= before) time_us_ = before + (live_ ? 1 : period_us_);
  }

  std::filesystem::path path_;
  bool live_;
  cv::VideoCapture capture_;
  Camera camera_;
  int size_ = kNoEnd;
  std::string problem_;
  std::vector<std::string> notes_;
  int at_ = -1;  // the image at hand
  bool ended_ = false;
  std::int64_t time_us_ = 0;    // of that image
  std::int64_t period_us_ = 1;  // between images of a video without times
};

OpenedSource opened(const std::filesystem::path& path, bool live, const SequenceOptions& options) {
  auto source = std::make_unique<CaptureSource>(path, live);
  if (std::string problem = source->open(options); !problem.empty()) return {nullptr, problem};
  return {std::move(source), ""};
}

}  // namespace

OpenedSource open_video(const std::filesystem::path& file, const SequenceOptions& options) {
  return opened(file, false, options);
}

OpenedSource open_device(const std::filesystem::path& device, const SequenceOptions& options) {
  return opened(device, true, options);
}

}  // namespace eifmap
