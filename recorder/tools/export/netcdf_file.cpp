#include "recorder/tools/export/netcdf_file.h"

#include <netcdf.h>

#include <algorithm>
#include <limits>

namespace roseau::recorder {

namespace {
constexpr int kCompression = 2;
constexpr std::size_t kChunkRows = 4096;
}  // namespace

Result<std::unique_ptr<NetcdfFile>> NetcdfFile::create(const std::filesystem::path& path) {
  if (auto absent = require_absent(path); !absent) return absent.error();
  int id = 0;
  const int status = nc_create(path.c_str(), NC_NETCDF4 | NC_NOCLOBBER, &id);
  if (status != NC_NOERR) return Error{ErrorCode::io, "cannot make " + path.string() + ": " + nc_strerror(status)};
  return std::unique_ptr<NetcdfFile>(new NetcdfFile(id, path));
}

NetcdfFile::~NetcdfFile() {
  if (is_open_) nc_close(id_);
}

void NetcdfFile::check(int status) {
  if (status != NC_NOERR && fault_.empty()) fault_ = nc_strerror(status);
}

int NetcdfFile::dimension(const std::string& name, std::size_t size) {
  int id = -1;
  if (fault_.empty()) check(nc_def_dim(id_, name.c_str(), size == kUnlimited ? NC_UNLIMITED : size, &id));
  return id;
}

int NetcdfFile::variable(const std::string& name, const std::vector<int>& dimensions, bool is_coordinate) {
  int id = -1;
  if (!fault_.empty()) return id;
  check(nc_def_var(id_, name.c_str(), NC_DOUBLE, static_cast<int>(dimensions.size()), dimensions.data(), &id));
  if (dimensions.empty() || !fault_.empty()) return id;
  std::vector<std::size_t> chunk(dimensions.size(), kChunkRows);
  for (std::size_t i = 1; i < dimensions.size(); ++i) check(nc_inq_dimlen(id_, dimensions[i], &chunk[i]));
  check(nc_def_var_chunking(id_, id, NC_CHUNKED, chunk.data()));
  check(nc_def_var_deflate(id_, id, 1, 1, kCompression));
  if (!is_coordinate) attribute(id, "_FillValue", std::numeric_limits<double>::quiet_NaN());
  return id;
}

int NetcdfFile::text_variable(const std::string& name, const std::vector<std::string>& texts, int over) {
  std::size_t width = 1;
  for (const auto& text : texts) width = std::max(width, text.size());
  std::vector<int> dimensions;
  if (over >= 0) dimensions.push_back(over);
  dimensions.push_back(dimension(name + "_strlen", width));
  int id = -1;
  if (!fault_.empty()) return id;
  check(nc_def_var(id_, name.c_str(), NC_CHAR, static_cast<int>(dimensions.size()), dimensions.data(), &id));
  texts_.push_back({id, texts, width, over < 0});
  return id;
}

void NetcdfFile::attribute(int variable, const std::string& name, const std::string& text) {
  if (fault_.empty())
    check(nc_put_att_text(id_, variable == kGlobal ? NC_GLOBAL : variable, name.c_str(), text.size(), text.data()));
}

void NetcdfFile::attribute(int variable, const std::string& name, double number) {
  if (fault_.empty())
    check(nc_put_att_double(id_, variable == kGlobal ? NC_GLOBAL : variable, name.c_str(), NC_DOUBLE, 1, &number));
}

void NetcdfFile::end_definitions() {
  if (!is_defining_ || !fault_.empty()) return;
  is_defining_ = false;
  check(nc_enddef(id_));
  for (const Text& text : texts_) {
    for (std::size_t i = 0; i < text.texts.size() && fault_.empty(); ++i) {
      std::string padded = text.texts[i];
      padded.resize(text.width, '\0');
      const std::size_t start[] = {i, 0};
      const std::size_t count[] = {1, text.width};
      check(nc_put_vara_text(id_, text.variable, start + (text.is_scalar ? 1 : 0), count + (text.is_scalar ? 1 : 0),
                             padded.data()));
    }
  }
}

void NetcdfFile::put(int variable, std::size_t first_row, std::size_t rows, std::size_t per_row,
                     std::span<const double> values) {
  end_definitions();
  if (!fault_.empty() || values.empty()) return;
  ROSEAU_CHECK(values.size() == rows * per_row);
  const std::size_t start[] = {first_row, 0};
  const std::size_t count[] = {rows, per_row};
  check(nc_put_vara_double(id_, variable, start, count, values.data()));
}

void NetcdfFile::put_scalar(const std::string& name, const std::optional<double>& value) {
  end_definitions();
  int id = -1;
  if (value && fault_.empty()) check(nc_inq_varid(id_, name.c_str(), &id));
  if (value && fault_.empty()) check(nc_put_var_double(id_, id, &*value));
}

Result<void> NetcdfFile::status() const {
  if (fault_.empty()) return {};
  return Error{ErrorCode::io,
               "cannot write " + path_.string() + ": " + fault_ + " (is the disk full?); the unfinished file was removed"};
}

Result<void> NetcdfFile::close() {
  end_definitions();
  is_open_ = false;
  check(nc_close(id_));
  if (fault_.empty()) removal_.keep();
  return status();
}

}  // namespace roseau::recorder
