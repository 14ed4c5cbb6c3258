#include "recorder/tools/import/tob1.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include "recorder/tools/import/text_table.h"

namespace roseau::recorder {

namespace {

constexpr std::size_t kHeaderLines = 5;
constexpr Duration kSince1990 = std::chrono::sys_days(std::chrono::year{1990} / 1 / 1).time_since_epoch();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i > 0; --i) value = value << 8U | static_cast<std::uint8_t>(bytes[i - 1]);
  return value;
}

// As parse_cell says of text: Campbell's codes for out of range.
double measured(double value) { return value == 7999 || value == -7999 || std::isinf(value) ? kNaN : value; }

}  // namespace

double decode_fp2(std::uint16_t bits) {
  constexpr std::uint16_t kMantissa = 0x1FFF;
  const auto mantissa = static_cast<std::uint16_t>(bits & kMantissa);
  if (mantissa >= kMantissa - 1) return kNaN;  // 1FFF and 9FFF: infinite; 9FFE: not a number
  constexpr std::array kScale = {1.0, 10.0, 100.0, 1000.0};
  const double value = mantissa / kScale.at(bits >> 13U & 3U);
  return measured((bits & 0x8000U) != 0 ? -value : value);
}

Result<std::unique_ptr<Tob1Table>> Tob1Table::open(FileReader file) {
  std::unique_ptr<Tob1Table> table(new Tob1Table(std::move(file)));
  if (auto read = table->read_head(); !read) return read.error();
  return table;
}

Result<void> Tob1Table::read_head() {
  std::array<std::vector<std::string>, kHeaderLines> lines;
  for (auto& names : lines) {
    const auto line = file_.line();
    if (!line) return line.error();
    if (!*line || !file_.line_had_end())
      return Error{ErrorCode::truncated, head_.source_name + ": the five header lines of a TOB1 file are not complete"};
    std::vector<std::string_view> fields;
    split_fields(**line, ',', fields);
    names.assign(fields.begin(), fields.end());
  }
  if (lines[0].front() != "TOB1") {
    return Error{ErrorCode::unsupported,
                 fmt::format("{}: begins with {}, not TOB1: convert it to TOB1 or TOA5 (Campbell's CardConvert)",
                             head_.source_name, lines[0].front().substr(0, 16))};
  }
  head_.columns = lines[1];
  // Without units for the last columns, some loggers leave their commas out too.
  head_.units = lines[2];
  head_.units.resize(head_.columns.size());
  head_.epoch = kSince1990;
  if (lines[0].size() == 8) head_.description = fmt::format("logger {} '{}', table {}", lines[0][2], lines[0][1], lines[0][7]);
  if (lines[4].size() != head_.columns.size()) {
    return Error{ErrorCode::corrupt, fmt::format("{}:5: {} types for {} columns ({})", head_.source_name, lines[4].size(),
                                                 head_.columns.size(), head_.column_list())};
  }
  for (const auto& type : lines[4]) {
    if (auto added = add_field(type); !added) return added;
  }
  if (record_size_ == 0 || record_size_ > kLongestRecord)
    return Error{ErrorCode::corrupt, fmt::format("{}:5: records of {} bytes make no sense", head_.source_name, record_size_)};
  return {};
}

Result<void> Tob1Table::add_field(std::string_view type) {
  struct Known {
    std::string_view name;
    Type type;
    std::size_t size;
  };
  constexpr std::array kKnown = {
      Known{"FP2", Type::fp2, 2},
      Known{"IEEE4", Type::ieee4, 4},
      Known{"IEEE4L", Type::ieee4, 4},
      Known{"IEEE8", Type::ieee8, 8},
      Known{"ULONG", Type::unsigned_integer, 4},
      Known{"UINT4", Type::unsigned_integer, 4},
      Known{"UINT2", Type::unsigned_integer, 2},
      Known{"LONG", Type::signed_integer, 4},
      Known{"INT4", Type::signed_integer, 4},
      Known{"INT2", Type::signed_integer, 2},
      Known{"BOOL", Type::unsigned_integer, 1},
      Known{"BOOL2", Type::unsigned_integer, 2},
      Known{"BOOL4", Type::unsigned_integer, 4},
      Known{"BOOL8", Type::unsigned_integer, 8},
      Known{"SecNano", Type::sec_nano, 8},
  };
  const auto bracket = type.find('(');
  const auto name = type.substr(0, bracket);
  Field field{.offset = record_size_};
  for (const auto& known : kKnown) {
    if (in_lower_case(known.name) != in_lower_case(type)) continue;
    field.type = known.type;
    field.size = known.size;
  }
  if (name == "ASCII" || name == "STRING") {
    const auto digits = bracket == std::string_view::npos ? std::string_view() : type.substr(bracket + 1);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), field.size);
    if (error != std::errc{} || end + 1 != digits.data() + digits.size() || *end != ')' || field.size > kLongestRecord)
      field.size = 0;
  }
  if (field.size == 0) {
    return Error{
        ErrorCode::unsupported,
        fmt::format("{}:5: type '{}' is not known; known are FP2, IEEE4, IEEE8, ULONG, LONG, UINT2, UINT4, INT2, INT4, "
                    "SecNano, BOOL, BOOL2, BOOL4, BOOL8, ASCII(n)",
                    head_.source_name, type.substr(0, 32))};
  }
  record_size_ += field.size;
  if (record_size_ > kLongestRecord)
    return Error{ErrorCode::corrupt,
                 fmt::format("{}:5: records of more than {} bytes make no sense", head_.source_name, kLongestRecord)};
  fields_.push_back(field);
  return {};
}

Result<void> Tob1Table::rewind() {
  was_cut_ = false;
  record_number_ = 0;
  if (auto rewound = file_.rewind(); !rewound) return rewound;
  for (std::size_t i = 0; i < kHeaderLines; ++i) {
    const auto line = file_.line();
    if (!line) return line.error();
  }
  return {};
}

Result<bool> Tob1Table::next() {
  const auto bytes = file_.take(record_size_);
  if (!bytes) return bytes.error();
  was_cut_ = !bytes->empty() && bytes->size() < record_size_;
  if (bytes->size() < record_size_) return false;
  record_ = *bytes;
  ++record_number_;
  return true;
}

Result<double> Tob1Table::number(std::size_t column) const {
  const auto& field = fields_[column];
  const auto bytes = bytes_of(field);
  const auto bits = little_endian(bytes.substr(0, 8));
  switch (field.type) {
    case Type::fp2:
      return decode_fp2(static_cast<std::uint16_t>((bits & 0xFFU) << 8U | bits >> 8U));
    case Type::ieee4:
      return measured(static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
    case Type::ieee8:
      return measured(std::bit_cast<double>(bits));
    case Type::unsigned_integer:
      return static_cast<double>(bits);
    case Type::signed_integer:
      return static_cast<double>(field.size == 2 ? static_cast<std::int16_t>(bits) : static_cast<std::int32_t>(bits));
    case Type::sec_nano:
      return static_cast<double>(static_cast<std::int32_t>(bits)) +
             1e-9 * static_cast<double>(static_cast<std::int32_t>(bits >> 32U));
    case Type::text:
      break;
  }
  // Numbers may be kept as text.
  const auto text = bytes.substr(0, bytes.find('\0'));
  const Cell cell = parse_cell(text, ',');
  if (cell.kind == Cell::Kind::number) return cell.number;
  if (cell.kind == Cell::Kind::missing) return kNaN;
  return Error{ErrorCode::corrupt, fmt::format("{}: record {}: column '{}' holds text, no number", head_.source_name,
                                               record_number_, head_.columns[column])};
}

Result<Duration> Tob1Table::time_stamp(std::size_t column) const {
  const auto& field = fields_[column];
  if (field.type == Type::sec_nano) {
    const auto bits = little_endian(bytes_of(field));
    return kSince1990 + std::chrono::seconds{static_cast<std::int32_t>(bits)} +
           Duration{static_cast<std::int32_t>(bits >> 32U)};
  }
  const auto seconds = number(column);
  if (!seconds) return seconds.error();
  constexpr double kMost_s = 4e9;
  if (!(*seconds >= 0 && *seconds <= kMost_s)) {
    return Error{ErrorCode::corrupt, fmt::format("{}: record {}: {} in column '{}' is no time", head_.source_name,
                                                 record_number_, *seconds, head_.columns[column])};
  }
  return kSince1990 + from_seconds(*seconds);
}

}  // namespace roseau::recorder
