// The embedded FileDescriptorSets; descriptors.cpp is generated at build time.
#pragma once

#include <span>
#include <string_view>

namespace roseau::schema {

struct DescriptorSet {
  std::string_view name;   // "roseau.Wind"
  std::string_view bytes;  // serialised google.protobuf.FileDescriptorSet with every import
};

std::span<const DescriptorSet> descriptor_sets();

}  // namespace roseau::schema
