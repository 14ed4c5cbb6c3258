// The two ways a cylinder table is written.
#include <fmt/format.h>
#include <matio.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include "structure/tree/qsm.h"

namespace roseau::structure {

namespace {

constexpr std::size_t kFewestColumns = 9;
constexpr std::size_t kMostRows = 2'000'000;
constexpr std::size_t kMostColumns = 1000;

bool is_separator(char c) { return c == ' ' || c == '\t' || c == '\r' || c == ',' || c == ';'; }

/// Adds the numbers of one line; false where a word is no number.
bool add_numbers(std::string_view line, std::vector<double>& values) {
  for (;;) {
    while (!line.empty() && is_separator(line.front())) line.remove_prefix(1);
    if (line.empty()) return true;
    if (line.front() == '+') line.remove_prefix(1);
    double value = 0;
    const auto [end, status] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (status != std::errc()) return false;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && !is_separator(line.front())) return false;
    values.push_back(value);
  }
}

bool is_comment(std::string_view line) {
  while (!line.empty() && is_separator(line.front())) line.remove_prefix(1);
  return line.empty() || line.front() == '#' || line.front() == '%' || line.front() == '"' ||
         std::isalpha(static_cast<unsigned char>(line.front())) != 0;
}

Result<QsmTable> parse_table(std::string_view text, const std::string& source_name) {
  QsmTable table;
  std::size_t line_number = 0;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line_number;
    if (is_comment(line)) continue;
    const auto error = [&](const std::string& what) {
      return Error{ErrorCode::corrupt, fmt::format("{}:{}: {}", source_name, line_number, what)};
    };
    const std::size_t before = table.values.size();
    if (!add_numbers(line, table.values)) return error("is no row of numbers");
    const std::size_t count = table.values.size() - before;
    if (table.columns == 0) table.columns = count;
    if (count != table.columns) return error(fmt::format("has {} numbers, the rows before have {}", count, table.columns));
    table.lines.push_back(line_number);
    if (table.lines.size() > kMostRows) return error(fmt::format("more than {} cylinders", kMostRows));
  }
  return table;
}

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using MatFile = std::unique_ptr<mat_t, CloseMat>;
using MatVariable = std::unique_ptr<matvar_t, FreeVariable>;

bool could_be_cylinders(const matvar_t& variable) {
  const bool is_real = variable.isComplex == 0;
  const bool is_number = variable.class_type == MAT_C_SINGLE || variable.class_type == MAT_C_DOUBLE;
  return is_real && is_number && variable.rank == 2 && variable.dims != nullptr && variable.dims[0] > 0 &&
         variable.dims[1] >= kFewestColumns;
}

/// MATLAB stores column by column.
template <class T>
void transpose(const matvar_t& variable, QsmTable& table) {
  const auto* data = static_cast<const T*>(variable.data);
  const std::size_t rows = variable.dims[0];
  table.columns = variable.dims[1];
  table.values.resize(rows * table.columns);
  for (std::size_t row = 0; row < rows; ++row) {
    table.lines.push_back(row + 1);
    for (std::size_t column = 0; column < table.columns; ++column) {
      table.values[row * table.columns + column] = static_cast<double>(data[column * rows + row]);
    }
  }
}

Result<QsmTable> read_table(const std::filesystem::path& path) {
  const auto error = [&path](ErrorCode code, const std::string& what) { return Error{code, path.string() + ": " + what}; };
  if (!std::filesystem::is_regular_file(path)) return error(ErrorCode::not_found, "is no file; is the path right?");
  const MatFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (file == nullptr) return error(ErrorCode::corrupt, "cannot be read as a MATLAB file");
  while (const MatVariable variable{Mat_VarReadNextInfo(file.get())}) {
    if (!could_be_cylinders(*variable)) continue;
    if (variable->dims[0] > kMostRows || variable->dims[1] > kMostColumns) {
      return error(ErrorCode::unsupported, fmt::format("{}: {} x {} is too large for a table of cylinders", variable->name,
                                                       variable->dims[0], variable->dims[1]));
    }
    const std::size_t cells = variable->dims[0] * variable->dims[1];
    if (Mat_VarReadDataAll(file.get(), variable.get()) != 0 || variable->data == nullptr || variable->data_size <= 0 ||
        variable->nbytes < cells * static_cast<std::size_t>(variable->data_size)) {
      return error(ErrorCode::truncated, fmt::format("{}: its numbers cannot be read", variable->name));
    }
    QsmTable table;
    if (variable->class_type == MAT_C_SINGLE && variable->data_size == sizeof(float)) {
      transpose<float>(*variable, table);
    } else if (variable->class_type == MAT_C_DOUBLE && variable->data_size == sizeof(double)) {
      transpose<double>(*variable, table);
    } else {
      return error(ErrorCode::corrupt, fmt::format("{}: its numbers have a strange size", variable->name));
    }
    return table;
  }
  return error(ErrorCode::unsupported, "holds no matrix of at least 9 columns (radius, length, start, axis, parent)");
}

}  // namespace

Result<ImportedTree> read_qsm_text(std::string_view text, const std::string& source_name) {
  const auto table = parse_table(text, source_name);
  if (!table) return table.error();
  return tree_from_cylinders(*table, source_name);
}

Result<ImportedTree> read_qsm_mat(const std::filesystem::path& path) {
  const auto table = read_table(path);
  if (!table) return table.error();
  return tree_from_cylinders(*table, path.string());
}

}  // namespace roseau::structure
