#include "names.h"

namespace eifmap {

std::string_view name(PoseSource source) {
  switch (source) {
    case PoseSource::kNone:
      return "NONE";
    case PoseSource::kScaleFit:
      return "SCALE_FIT";
    case PoseSource::kMapOnly:
      return "MAP_ONLY";
    case PoseSource::kPnp:
      return "PNP";
    case PoseSource::kRelocalized:
      return "RELOCALIZED";
    case PoseSource::kStartSet:
      return "START_SET";
  }
  return "UNKNOWN";
}

std::string_view name(TrackingState state) {
  switch (state) {
    case TrackingState::kWaiting:
      return "WAITING";
    case TrackingState::kStarting:
      return "STARTING";
    case TrackingState::kTracking:
      return "TRACKING";
    case TrackingState::kLost:
      return "LOST";
  }
  return "UNKNOWN";
}

std::string_view name(ScaleStatus status) {
  return status == ScaleStatus::kFixed ? "metric" : "arbitrary";
}

std::string_view name(EarthStatus status) {
  switch (status) {
    case EarthStatus::kUnknown:
      break;
    case EarthStatus::kLevel:
      return "level";
    case EarthStatus::kPlaced:
      return "placed";
  }
  return "unknown";
}

std::string_view name(InnovationKind kind) {
  switch (kind) {
    case InnovationKind::kSight:
      return "sights";
    case InnovationKind::kEdge:
      return "edges";
  }
  return "unknown";
}

}  // namespace eifmap
