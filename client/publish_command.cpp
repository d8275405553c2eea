#include <spdlog/spdlog.h>

#include <fstream>
#include <map>

#include "bus/lcm_bus.h"
#include "client/commands.h"
#include "client/publisher.h"

namespace eifmap {
namespace {

struct Options {
  std::string folder, lcm_url = kDefaultLcmUrl;
  SimulationOptions simulation;
  bool simulate = false;
  double start_delay_s = 0;
  int max_frames = 0;
  PublishOptions publish;
};

std::unique_ptr<ImageSource> open_source(const Options& options) {
  if (options.simulate == !options.folder.empty()) {
    spdlog::error("publish wants either a recorded folder or --simulate courtyard");
    return nullptr;
  }
  std::unique_ptr<ImageSource> source;
  if (options.simulate) {
    if (const auto problem = options.simulation.problem(); !problem.empty()) {
      spdlog::error(problem);
      return nullptr;
    }
    source = make_source(SimulatedWorld(options.simulation));
  } else {
    auto opened = RecordedSequence::open(options.folder);
    if (!opened.sequence) {
      spdlog::error(opened.problem);
      return nullptr;
    }
    source = make_source(std::move(*opened.sequence));
  }
  return options.max_frames > 0 ? first_images(std::move(source), options.max_frames)
                                : std::move(source);
}

// Datagrams of an image that does not fit the receiver's buffer are lost without a word.
void warn_of_large_images(const Options& options, const Camera& camera) {
  constexpr long kSafeBytes = 200'000, kEnough = 2'097'152;
  const long bytes = static_cast<long>(camera.width) * camera.height;
  if (options.publish.as != PublishAs::kRaw || bytes <= kSafeBytes ||
      !options.lcm_url.starts_with("udpm://"))
    return;
  long granted = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> granted;
  if (granted >= kEnough) return;
  spdlog::warn(
      "raw images of {} bytes are mostly lost while net.core.rmem_max is {}: use --as mjpeg or "
      "--as "
      "features, or, as root on the receiver: sysctl -w net.core.rmem_max={}",
      bytes, granted, kEnough);
}

int run(Options& options, StopSignals& signals) {
  options.publish.start_delay =
      std::chrono::milliseconds(static_cast<std::int64_t>(1000 * options.start_delay_s));
  if (const auto problem = options.publish.problem(); !problem.empty()) {
    spdlog::error(problem);
    return kBadOptions;
  }
  const auto source = open_source(options);
  if (!source) return kBadOptions;
  const LcmBus::Opened opened = LcmBus::open(options.lcm_url);
  if (!opened.bus) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  warn_of_large_images(options, source->camera());
  spdlog::info("{} images of {} as camera {} on {}", source->size(), source->name(),
               options.publish.camera, options.lcm_url);
  const PublishResult result = publish(*source, options.publish, *opened.bus,
                                       [&signals](int) { return !signals.arrived(); });
  spdlog::info("published {} of {} images, publisher {}", result.published, source->size(),
               result.publisher);
  if (result.late_s > 0.5)
    spdlog::warn("up to {:.1f} s late: this machine is slower than the recording", result.late_s);
  if (result.problem.empty()) return 0;
  spdlog::error(result.problem);
  return kFailed;
}

}  // namespace

Command add_publish_command(CLI::App& app) {
  static const std::map<std::string, PublishAs> kWays{
      {"raw", PublishAs::kRaw}, {"mjpeg", PublishAs::kMjpeg}, {"features", PublishAs::kFeatures}};
  static const std::map<std::string, ExtractorKind> kExtractors(kExtractorNames.begin(),
                                                                kExtractorNames.end());
  auto* command =
      app.add_subcommand("publish", "send the images of a recording, or of a simulated camera");
  const auto options = std::make_shared<Options>();
  PublishOptions& publish = options->publish;
  command->add_option("folder", options->folder, "recorded folder: images/, times.txt, calib.json");
  command->add_option("--simulate", options->simulation.world, "a simulated world: courtyard")
      ->each([options](const std::string&) { options->simulate = true; });
  command->add_flag("--distorted", options->simulation.distorted, "simulate a cheap lens");
  command->add_flag("--fisheye", options->simulation.fisheye, "simulate a fisheye lens");
  command->add_option("--seed", options->simulation.seed, "of the simulated noise and surfaces");
  command->add_option("--motion", options->simulation.motion,
                      "of the simulated camera: lap, or turn (straight on, with fast turns)");
  command->add_option("--roll-deg", options->simulation.roll_deg,
                      "how far the simulated camera is slowly rolled");
  command->add_option("--as", publish.as, "raw, mjpeg or features (the default)")
      ->transform(CLI::CheckedTransformer(kWays));
  command
      ->add_option("--extractor", publish.features.extractor,
                   "of --as features; the default is the server's")
      ->transform(CLI::CheckedTransformer(kExtractors));
  command->add_option("--jpeg-quality", publish.jpeg_quality, "where images are no JPEG yet")
      ->check(CLI::Range(1, 100));
  command
      ->add_option("--rate", publish.rate_hz,
                   "images a second; 0: as fast as it can; default: as recorded")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--camera", publish.camera, "name of the camera in the channels");
  command->add_option("--publisher", publish.publisher, "id of this publisher; default: random")
      ->check(CLI::PositiveNumber);
  command->add_option("--start-delay", options->start_delay_s, "seconds before the first image")
      ->check(CLI::Range(0.0, 3600.0));
  command->add_option("--max-frames", options->max_frames, "stop after so many images")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--lcm-url", options->lcm_url, "network to publish on");
  return [command, options](StopSignals& signals) {
    return command->parsed() ? run(*options, signals) : -1;
  };
}

}  // namespace eifmap
