// Which recorded message carries which kind of sample, and the schema text (protobuf FileDescriptorSet) that goes with it.
// The .proto files in proto/ are a public contract: see README.md for how they may change.
#pragma once

#include <optional>
#include <string_view>

#include "core/sample.h"

namespace roseau::schema {

/// Version of the messages as a whole, written into every session. It rises when an older program would misread a newer
/// file: a field changed its meaning, a kind changed its message. New fields and new kinds do not raise it: older programs
/// skip fields they do not know, and say which topics they cannot read.
inline constexpr int kSchemaVersion = 1;

/// Message and schema encoding name in MCAP and in the live protocol.
inline constexpr std::string_view kEncoding = "protobuf";

struct Schema {
  std::string_view name;            // fully qualified message name: "roseau.Wind", "foxglove.RawImage"
  std::string_view descriptor_set;  // bytes of a FileDescriptorSet holding that message and everything it uses
};

/// The message that carries samples of this kind. Both views live as long as the program.
Schema schema_of(SampleKind kind);
std::string_view schema_name(SampleKind kind);
std::string_view descriptor_set(SampleKind kind);

/// The kind of sample that a message of this name carries; nothing for messages this program does not know.
std::optional<SampleKind> kind_of_schema(std::string_view schema_name);

/// foxglove.CompressedImage: the other message of frames, where they are stored coded (conversion.h: serialize_coded_head), and
/// that of small pictures for live viewers. kind_of_schema knows it.
Schema compressed_image_schema();

}  // namespace roseau::schema
