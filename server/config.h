// The server's configuration: a JSON object with the sections of the options' structs.
#pragma once

#include <optional>
#include <string>

#include "bus/default_url.h"
#include "features/extractor.h"
#include "geometry/camera.h"
#include "options.h"
#include "program/listen_at.h"
#include "published/map_part.h"
#include "server/inbox.h"
#include "server/keyframe_worker.h"

namespace eifmap {

struct ServerConfig {
  // The LCM network: ttl=0 stays on this machine, ttl=1 in its network.
  std::string lcm_url = kDefaultLcmUrl;
  // The only camera to map; "": every one that is heard, each with a map of its own.
  std::string camera;
  // Mapped at most, where no camera is named; what comes of more is refused. Limits of memory and
  // pace are of each.
  int max_cameras = 8;
  // One more channel whose images are that camera's, for drivers with channel names of their own.
  std::string image_channel;
  // Of the 16 bits of a LE_GRAY16 pixel, how many the camera fills: 10, 12, 14, ...
  int gray16_bits = 16;
  // Newest: the map keeps up with the camera, at the price of frames. Lossless: every frame, late.
  // What max_queued_mib then has no room for waits in LCM's own queue where a camera is named, and
  // is lost when that is full; where none is, others would wait with it: it is dropped and counted.
  InputMode input = InputMode::kNewest;
  int max_queued_mib = 256;  // MiB of a camera's input waiting for its mapper
  // Largest message of a map update, in bytes. 0: what fits a datagram of the network, 1400 where
  // the ttl is above 0, else 32768.
  int max_part_bytes = 0;
  // Of one camera's map: a pace that stock receive buffers keep up with.
  int map_bytes_per_s = 5'000'000;
  double status_period_s = 1;  // s between two statuses, when nothing changes
  // Who may command (eifmap ctl): who signs with what this file holds, 16 bytes or more that others
  // cannot read. "": anybody on this machine, and nobody where the network reaches beyond it.
  std::string secret_file;
  std::optional<Camera> calibration;  // of each camera, instead of waiting for one by message
  // A camera without a calibration: the width of its view, from which a pinhole is guessed; 0: wait
  // for its calibration. The status says that it is guessed.
  double hfov_deg = 0;
  // Keyframes go into the map beside the frames that come meanwhile. Before which frame after its
  // own the result is adopted, waited for if need be; 0: at once, each keyframe's own pose waits
  // for the map; -1: as soon as it is done, when live and with newest input, which the decisions
  // record, else at once.
  int handover_frames = -1;
  // Where maps are kept, a folder for each camera: after a restart, or a crash, mapping goes on
  // with what was published. "": nowhere.
  std::string maps_folder;
  // Figures for Prometheus, served at http://ADDRESS:PORT/metrics. 0: none.
  int metrics_port = 0;
  // IPv4, of this machine; whoever reaches it can read them.
  std::string metrics_address = "127.0.0.1";
  FeatureOptions features;
  MapperOptions mapper;

  std::string problem() const;  // "" or which value is wrong and why
  std::size_t part_bytes() const;
  ListenAt metrics_at() const;
  Handover live_handover() const;
  Handover recorded_handover() const;  // of recorded images
};

struct ParsedConfig {
  ServerConfig config;
  std::string problem;  // "" or which key or value is wrong, by its full name, and what was wanted
};

// Keys that are left out keep the values of `base`; unknown keys are refused.
ParsedConfig parse_config(const std::string& json_text, const ServerConfig& base = {});

// The whole of it as JSON, which parse_config reads back.
std::string config_text(const ServerConfig& config);

}  // namespace eifmap
