// NetcdfFile: a new netCDF-4 file. The one place that knows libnetcdf.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "recorder/tools/export/output_file.h"

namespace roseau::recorder {

/// The first error stays: later calls do nothing, close() says it and the file is removed. So it is unless closed.
class NetcdfFile {
 public:
  static constexpr std::size_t kUnlimited = 0;
  static constexpr int kGlobal = -1;  // instead of a variable: attributes of the file

  static Result<std::unique_ptr<NetcdfFile>> create(const std::filesystem::path& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  int dimension(const std::string& name, std::size_t size);
  /// Of doubles, compressed, NaN being its _FillValue unless it is a coordinate.
  int variable(const std::string& name, const std::vector<int>& dimensions, bool is_coordinate = false);
  /// A text, or one per element of a dimension.
  int text_variable(const std::string& name, const std::vector<std::string>& texts, int dimension = -1);
  void attribute(int variable, const std::string& name, const std::string& text);
  void attribute(int variable, const std::string& name, double number);

  /// `values`: `rows` rows of the record dimension from `first_row` on; with a second dimension row by row.
  void put(int variable, std::size_t first_row, std::size_t rows, std::size_t per_row, std::span<const double> values);

  /// A scalar variable by its name; nothing to do without a value.
  void put_scalar(const std::string& name, const std::optional<double>& value);

  Result<void> status() const;
  Result<void> close();

 private:
  struct Text {
    int variable;
    std::vector<std::string> texts;
    std::size_t width;
    bool is_scalar;
  };
  NetcdfFile(int id, const std::filesystem::path& path) : id_(id), path_(path), removal_(path) {}
  void check(int status);
  void end_definitions();

  int id_;
  std::filesystem::path path_;
  RemoveUnlessKept removal_;
  std::vector<Text> texts_;
  bool is_defining_ = true;
  bool is_open_ = true;
  std::string fault_;
};

}  // namespace roseau::recorder
