#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>

#include "bus/lcm_bus.h"
#include "bus/link.h"
#include "capture/open_source.h"
#include "client/commands.h"
#include "client/publisher.h"
#include "program/command_line.h"
#include "program/progress_bar.h"
#include "sequence/measurements_file.h"

namespace eifmap {
namespace {

struct Options {
  std::string source, measurements, lcm_url = kDefaultLcmUrl;
  SequenceOptions sequence;
  SimulationOptions simulation;
  bool simulate = false, loop = false;
  double start_delay_s = 0;
  int max_frames = 0;
  std::optional<int> max_message_bytes, bytes_per_s;  // nothing: what suits the network
  PublishOptions publish;
};

OpenedSource open_named(const Options& options) {
  if (options.simulate == !options.source.empty())
    return {
        nullptr,
        options.simulate
            ? "publish sends either " + options.source +
                  " or what --simulate makes: leave one of them out"
            : "publish wants a source of images: a folder, a video, a camera as /dev/videoN, or "
              "--simulate courtyard"};
  if (!options.simulate) return open_source(options.source, options.sequence);
  if (!options.sequence.calibration.empty() || options.sequence.hfov_deg > 0)
    return {nullptr,
            "--calib and --hfov are of recorded images, and --simulate has a camera of its "
            "own: leave them out"};
  if (std::string problem = options.simulation.problem(); !problem.empty())
    return {nullptr, problem};
  return {make_source(SimulatedWorld(options.simulation)), ""};
}

OpenedSource open_source_of(const Options& options) {
  OpenedSource opened = open_named(options);
  if (!opened.source) return opened;
  if (options.loop) opened.source = looped(std::move(opened.source));
  if (options.max_frames > 0)
    opened.source = first_images(std::move(opened.source), options.max_frames);
  return opened;
}

// Returns "" or what is wrong.
std::string read_measurements_into(PublishOptions& publish, const Options& options,
                                   const ImageSource& source) {
  if (options.measurements.empty()) return "";
  if (options.loop || source.live())
    return "--measurements has times of its own, and those of " +
           std::string(options.loop ? "--loop" : "a camera") + " are others: leave one of them out";
  MeasurementsFile file = read_measurements(options.measurements);
  publish.measurements = std::move(file.measurements);
  return file.problem;
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

// How many there are, for people.
std::string count_text(const ImageSource& source) {
  return source.size() == ImageSource::kNoEnd ? "images"
                                              : std::to_string(source.size()) + " images";
}

PublishResult publish_all(ImageSource& source, const Options& options, Bus& bus,
                          StopSignals& signals) {
  ProgressBar bar(std::cerr, isatty(STDERR_FILENO) != 0);
  return publish(source, options.publish, bus, [&](int done) {
    bar.show(done, source.size());
    return !signals.arrived();
  });
}

int run(Options& options, StopSignals& signals) {
  options.publish.start_delay =
      std::chrono::milliseconds(static_cast<std::int64_t>(1000 * options.start_delay_s));
  const Link link = link_of(options.lcm_url);
  options.publish.max_message_bytes = options.max_message_bytes.value_or(link.message_bytes);
  options.publish.bytes_per_s = options.bytes_per_s.value_or(link.bytes_per_s);
  options.sequence.rate_hz = std::max(0.0, options.publish.rate_hz);
  for (const std::string& problem : {options.publish.problem(), options.sequence.problem()})
    if (!problem.empty()) {
      spdlog::error(problem);
      return kBadOptions;
    }
  const OpenedSource images = open_source_of(options);
  if (!images.source) {
    spdlog::error(images.problem);
    return kBadOptions;
  }
  ImageSource& source = *images.source;
  if (const std::string problem = read_measurements_into(options.publish, options, source);
      !problem.empty()) {
    spdlog::error(problem);
    return kBadOptions;
  }
  const LcmBus::Opened opened = LcmBus::open(options.lcm_url);
  if (!opened.bus) {
    spdlog::error(opened.problem);
    return kFailed;
  }
  for (const std::string& note : source.notes()) spdlog::warn(note);
  warn_of_large_images(options, source.camera());
  spdlog::info("{} of {} ({}) as camera {} on {}", count_text(source), source.name(), source.kind(),
               options.publish.camera, options.lcm_url);
  const PublishResult result = publish_all(source, options, *opened.bus, signals);
  const bool ends = source.size() != ImageSource::kNoEnd;
  spdlog::info("published {}{} images in {} messages, publisher {}", result.published,
               ends ? " of " + std::to_string(source.size()) : "", result.messages,
               result.publisher);
  if (const std::size_t all = options.publish.measurements.size(); all > 0)
    spdlog::info("{} of {} measurements sent, those up to the last image", result.measurements,
                 all);
  if (result.late_s > 0.5)
    spdlog::warn("up to {:.1f} s late: this machine is slower than the recording", result.late_s);
  if (result.problem.empty()) return 0;
  spdlog::error(result.problem);
  return kFailed;
}

}  // namespace

Command add_publish_command(CLI::App& app) {
  constexpr std::array kWays{std::pair{"raw", PublishAs::kRaw},
                             std::pair{"mjpeg", PublishAs::kMjpeg},
                             std::pair{"features", PublishAs::kFeatures}};
  auto* command = app.add_subcommand(
      "publish", "send the images of a recording, of a camera, or of a simulated one");
  const auto options = std::make_shared<Options>();
  PublishOptions& publish = options->publish;
  command->add_option("source", options->source,
                      "a folder of images (eifmap, KITTI odometry, TUM RGB-D, EuRoC MAV, or images "
                      "alone), a video, or a camera: /dev/videoN or N");
  add_calibration_options(*command, options->sequence);
  command
      ->add_option("--simulate", options->simulation.world,
                   "a simulated world: courtyard, block, or one that is hard to map: tiles, wall, "
                   "street, corridor")
      ->each([options](const std::string&) { options->simulate = true; });
  command->add_flag("--distorted", options->simulation.distorted, "simulate a cheap lens");
  command->add_flag("--fisheye", options->simulation.fisheye, "simulate a fisheye lens");
  command->add_option("--seed", options->simulation.seed, "of the simulated noise and surfaces");
  command->add_option("--motion", options->simulation.motion,
                      "of the simulated camera: lap, turn (straight on, with fast turns), "
                      "look_around, pause, standstill, pan, sideways, drive, walk");
  command->add_option("--frames", options->simulation.num_frames,
                      "images that the simulated camera takes; default: 400");
  command->add_option("--speed", options->simulation.speed, "of the simulated camera, m/s");
  command->add_option(
      "--event", options->simulation.event,
      "on the way: black (no light), covered (half the image), bus (one drives through the "
      "street), kidnapped (no light, and the camera is elsewhere after it)");
  command->add_option("--event-from", options->simulation.event_from_s,
                      "when it begins, s; default: 6");
  command->add_option("--event-for", options->simulation.event_for_s,
                      "how long it lasts, s; default: 2");
  command->add_option("--event-to", options->simulation.event_to_s,
                      "where the kidnapped camera goes on: where it is so many s on its way; "
                      "default: 1");
  command->add_option("--roll-deg", options->simulation.roll_deg,
                      "how far the simulated camera is slowly rolled");
  command->add_option("--as", publish.as, "what to send; default: features")
      ->transform(one_of(as_numbers(kWays)));
  command
      ->add_option("--extractor", publish.features.extractor,
                   "of --as features; the default is the server's")
      ->transform(one_of(as_numbers(kExtractorNames)));
  command
      ->add_option("--features-cap", publish.features.max_features,
                   "of --as features: at most so many an image, the strongest of each region")
      ->check(number_in(1, 100000));
  command->add_option("--jpeg-quality", publish.jpeg_quality, "where images are no JPEG yet")
      ->check(number_in(1, 100));
  command
      ->add_option("--rate", publish.rate_hz,
                   "images a second; 0: as fast as it can; default: as recorded")
      ->check(number_in(0, 10000));
  command
      ->add_option("--max-message", options->max_message_bytes,
                   "of --as features: bytes; larger frames leave in parts; 0: whole; default: what "
                   "fits a datagram, 1400 where the network's ttl is above 0, else 32768")
      ->check(number_in(0, 1 << 26));
  command
      ->add_option("--bytes-per-s", options->bytes_per_s,
                   "of --as features: the pace of a frame's parts; 0: none; default: 5000000 where "
                   "the network's ttl is above 0, else none")
      ->check(number_in(0, 1'000'000'000));
  command->add_option("--measurements", options->measurements,
                      "absolute measurements, a JSON object a line, sent next to the images of "
                      "their times");
  command->add_flag("--loop", options->loop, "start again at the end; the times go on increasing");
  command->add_option("--camera", publish.camera, "name of the camera in the channels");
  command->add_option("--publisher", publish.publisher, "id of this publisher; default: random")
      ->check(number_in(1));
  command->add_option("--start-delay", options->start_delay_s, "seconds before the first image")
      ->check(number_in(0, 3600));
  command->add_option("--max-frames", options->max_frames, "stop after so many images")
      ->check(number_in(0));
  command->add_option("--lcm-url", options->lcm_url, "network to publish on");
  return [command, options](StopSignals& signals) {
    return command->parsed() ? run(*options, signals) : -1;
  };
}

}  // namespace eifmap
