#include "structure/animation/aligned_floats.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>

namespace roseau::structure {

namespace {

constexpr std::size_t kLine = 64;
constexpr std::size_t kLargePage = std::size_t{2} << 20;

}  // namespace

AlignedFloats::AlignedFloats(std::size_t count) : size_(count) {
  const std::size_t alignment = count * sizeof(float) >= kLargePage ? kLargePage : kLine;
  const std::size_t bytes = std::max<std::size_t>(1, (count * sizeof(float) + alignment - 1) / alignment) * alignment;
  auto* data = static_cast<float*>(std::aligned_alloc(alignment, bytes));
  if (data == nullptr) throw std::bad_alloc();
  data_.reset(data);
  // Only a wish: without large pages everything works, more slowly.
  if (alignment == kLargePage) madvise(data, bytes, MADV_HUGEPAGE);
  std::fill_n(data, bytes / sizeof(float), 0.0F);
}

void AlignedFloats::Free::operator()(float* data) const { std::free(data); }

}  // namespace roseau::structure
