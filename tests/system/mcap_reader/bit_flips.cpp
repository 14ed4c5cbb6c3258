// bit_flips write PATH      writes the small session that holds every kind of record
// bit_flips judge PATH      flips every bit of it, one at a time, and asks `verify`: JSON of how many were noticed, by region
//
// For the table of what is noticed, beside a reader that is not ours (bit_flips.test.mjs).
#include <cstdio>
#include <fstream>
#include <string_view>

#include "recorder/tools/inspect/verification.h"
#include "tests/support/every_record.h"

using namespace roseau;

namespace {

bool is_noticed(std::vector<std::byte> file, std::uint64_t bit) {
  file[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
  testing::MemoryReadable in(std::move(file));
  const auto found = recorder::verify_session(in);
  return !found || found->problem_count > 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc == 3 ? argv[1] : "";
  const auto file = testing::every_record();
  if (what == "write") {
    std::ofstream out(argv[2], std::ios::binary);
    out.write(reinterpret_cast<const char*>(file.bytes.data()), static_cast<std::streamsize>(file.bytes.size()));
    return out.good() ? 0 : 1;
  }
  if (what != "judge") {
    std::fprintf(stderr, "usage: bit_flips write|judge PATH\n");
    return 2;
  }
  std::ofstream out(argv[2]);
  out << "[";
  for (const auto& region : file.regions) {
    std::uint64_t noticed = 0;
    for (std::uint64_t bit = 8 * region.begin; bit < 8 * region.end; ++bit) noticed += is_noticed(file.bytes, bit) ? 1U : 0U;
    out << (region.begin == 0 ? "" : ",\n") << R"({"name": ")" << region.name << R"(", "begin": )" << region.begin
        << R"(, "end": )" << region.end << R"(, "noticed": )" << noticed << "}";
  }
  out << "]\n";
  return out.good() ? 0 : 1;
}
