// Campbell Scientific's TOB1: five header lines of text (station, names, units, processing, types), then records of binary
// values without anything between them (LoggerNet manual, appendix B).
//
//   FP2       2 bytes, big-endian: sign, two bits of negative decimal exponent, 13 bits of mantissa
//   IEEE4, IEEE8, ULONG, LONG, UINT2, UINT4, INT2, INT4     little-endian
//   SecNano   seconds since 1990-01-01 and nanoseconds, two LONGs
//   BOOL, BOOL2, BOOL4, BOOL8;  ASCII(n), STRING(n): n bytes of text
//
// Columns SECONDS and NANOSECONDS count from 1990 too, by the logger's clock.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recorder/tools/import/byte_source.h"
#include "recorder/tools/import/table.h"

namespace roseau::recorder {

class Tob1Table : public TableReader {
 public:
  static constexpr std::size_t kLongestRecord = 8192;

  /// Error: no TOB1 header, or a type that is not known, naming it.
  static Result<std::unique_ptr<Tob1Table>> open(FileReader file);

  Result<void> rewind() override;
  Result<bool> next() override;
  Result<double> number(std::size_t column) const override;
  Result<Duration> time_stamp(std::size_t column) const override;
  bool was_cut() const override { return was_cut_; }
  double share() const override { return file_.share(); }

 private:
  enum class Type : std::uint8_t { fp2, ieee4, ieee8, unsigned_integer, signed_integer, sec_nano, text };
  struct Field {
    Type type = Type::text;
    std::size_t offset = 0;
    std::size_t size = 0;
  };

  explicit Tob1Table(FileReader file) : file_(std::move(file)) { head_.source_name = file_.name(); }
  Result<void> read_head();
  Result<void> add_field(std::string_view type);
  std::string_view bytes_of(const Field& field) const { return record_.substr(field.offset, field.size); }

  FileReader file_;
  std::vector<Field> fields_;
  std::size_t record_size_ = 0;
  std::string_view record_;
  std::uint64_t record_number_ = 0;
  bool was_cut_ = false;
};

/// NaN for FP2's codes for "not a number" and for out of range.
double decode_fp2(std::uint16_t bits);

}  // namespace roseau::recorder
