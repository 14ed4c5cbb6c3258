// Files in memory, whole or broken on purpose.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/check.h"
#include "recorder/format/io.h"

namespace roseau::testing {

class MemoryWritable : public mcap::Writable {
 public:
  Result<void> append(std::span<const std::span<const std::byte>> parts) override {
    for (const auto& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
    return {};
  }
  Result<void> sync() override { return {}; }

  std::vector<std::byte> bytes;
};

class MemoryReadable : public mcap::Readable {
 public:
  explicit MemoryReadable(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  Result<void> read(std::uint64_t offset, std::span<std::byte> to) override {
    ROSEAU_CHECK(offset <= bytes_.size() && to.size() <= bytes_.size() - offset);
    std::ranges::copy(std::span(bytes_).subspan(offset, to.size()), to.begin());
    return {};
  }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace roseau::testing
