#include "schema/schemas.h"

#include <algorithm>
#include <array>

#include "core/check.h"
#include "schema/descriptors.h"

namespace roseau::schema {

namespace {
// In the order of SampleKind.
constexpr std::string_view kCompressedImage = "foxglove.CompressedImage";
constexpr std::array<std::string_view, kSampleKindCount> kNames = {"roseau.RawBytes",
                                                                   "foxglove.RawImage",
                                                                   "foxglove.CameraCalibration",
                                                                   "roseau.OperatorAction",
                                                                   "roseau.Skip",
                                                                   "roseau.Wind",
                                                                   "roseau.Displacement",
                                                                   "foxglove.ImageAnnotations",
                                                                   "roseau.Identification",
                                                                   "roseau.WindEstimate",
                                                                   "roseau.WindCalibration",
                                                                   "roseau.ForceSpectrum",
                                                                   "roseau.ClockState",
                                                                   "roseau.Gap",
                                                                   "roseau.Drop",
                                                                   "roseau.Health",
                                                                   "foxglove.Log",
                                                                   "foxglove.PoseInFrame",
                                                                   "roseau.LedBoardTime",
                                                                   "foxglove.PosesInFrame",
                                                                   "roseau.ModalState"};

Schema find_schema(std::string_view name) {
  const auto sets = descriptor_sets();
  const auto found = std::ranges::find(sets, name, &DescriptorSet::name);
  ROSEAU_CHECK(found != sets.end());
  return {found->name, found->bytes};
}
}  // namespace

Schema schema_of(SampleKind kind) { return find_schema(schema_name(kind)); }

std::string_view schema_name(SampleKind kind) { return kNames.at(static_cast<std::size_t>(kind)); }

std::string_view descriptor_set(SampleKind kind) { return schema_of(kind).descriptor_set; }

std::optional<SampleKind> kind_of_schema(std::string_view schema_name) {
  if (schema_name == kCompressedImage) return SampleKind::frame;
  const auto* found = std::ranges::find(kNames, schema_name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<SampleKind>(found - kNames.begin());
}

Schema compressed_image_schema() { return find_schema(kCompressedImage); }

}  // namespace roseau::schema
