#include "calib/model/model_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <span>
#include <sstream>

#include "calib/model/python_literal.h"
#include "core/check.h"

namespace roseau::calib {

namespace {

using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr std::uintmax_t kLargestFile = 64U << 20U;  // mrcal's files with all observations take a few megabytes

// Shortest text that gives the same double again, never with a locale's comma.
std::string digits(double number) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  ROSEAU_CHECK(error == std::errc{});
  return {text.data(), end};
}

std::string list(std::span<const double> numbers) {
  std::string text = "[";
  for (const double number : numbers) text += " " + digits(number) + ",";
  return text + "]";
}

// rt_cam_ref: rotation vector and translation that take a point of the world to the camera's frame.
std::array<double, 6> camera_from_world(const CameraModel& camera) {
  const Eigen::Map<const Rotation> rotation(camera.rotation_camera_from_world.data());
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(rotation).normalized()};
  const Eigen::Vector3d r = turn.angle() * turn.axis();
  const Vec3& p = camera.position_in_world_m;
  const Eigen::Vector3d t = -(rotation * Eigen::Vector3d(p.x, p.y, p.z));
  return {r.x(), r.y(), r.z(), t.x(), t.y(), t.z()};
}

void set_pose(CameraModel& camera, std::span<const double> rt) {
  const Eigen::Vector3d r(rt[0], rt[1], rt[2]);
  const double angle = r.norm();
  Eigen::Map<Rotation> rotation(camera.rotation_camera_from_world.data());
  rotation = angle > 0 ? Eigen::AngleAxisd(angle, r / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
  const Eigen::Vector3d position = -(rotation.transpose() * Eigen::Vector3d(rt[3], rt[4], rt[5]));
  camera.position_in_world_m = {position.x(), position.y(), position.z()};
}

class Reader {
 public:
  Reader(const PythonDictionary& entries, const std::string& source) : entries_(entries), source_(source) {}

  Result<CameraModel> camera() const {
    CameraModel camera;
    const Result<std::string> lens_name = text("lensmodel");
    if (!lens_name) return lens_name.error();
    const Result<Lens> lens = lens_from_string(*lens_name);
    if (!lens) return lens.error().with_context(source_);
    camera.lens = *lens;

    const Result<std::vector<double>> intrinsics = numbers("intrinsics", intrinsics_count(*lens));
    const Result<std::vector<double>> extrinsics = numbers("extrinsics", 6);
    const Result<std::vector<double>> size = numbers("imagersize", 2);
    for (const auto* read : {&intrinsics, &extrinsics, &size}) {
      if (!*read) return read->error();
    }
    std::ranges::copy(*intrinsics, camera.intrinsics.begin());
    set_pose(camera, *extrinsics);
    for (const double pixels : *size) {
      if (!(pixels >= 1 && pixels <= 1 << 20 && pixels == std::floor(pixels))) {
        return wrong(ErrorCode::corrupt, "imagersize", "must be two whole numbers of pixels");
      }
    }
    camera.width = static_cast<std::uint32_t>((*size)[0]);
    camera.height = static_cast<std::uint32_t>((*size)[1]);
    if (const Result<void> checked = check(camera); !checked) return checked.error().with_context(source_);
    return camera;
  }

 private:
  Error wrong(ErrorCode code, std::string_view key, std::string_view what) const {
    const auto found = entries_.find(key);
    const std::string where = found == entries_.end() ? source_ : fmt::format("{}:{}", source_, found->second.line);
    return {code, fmt::format("{}: '{}' {}", where, key, what)};
  }

  template <class T>
  Result<T> get(std::string_view key, const char* what) const {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return wrong(ErrorCode::corrupt, key, "is missing: this is not a camera model of mrcal");
    if (const T* value = std::get_if<T>(&found->second.value); value != nullptr) return *value;
    return wrong(ErrorCode::corrupt, key, what);
  }

  Result<std::string> text(std::string_view key) const { return get<std::string>(key, "must be a text"); }

  Result<std::vector<double>> numbers(std::string_view key, std::size_t count) const {
    Result<std::vector<double>> read = get<std::vector<double>>(key, "must be a list of numbers");
    if (read && read->size() != count) {
      return wrong(ErrorCode::corrupt, key, fmt::format("has {} numbers, the lens model needs {}", read->size(), count));
    }
    return read;
  }

  const PythonDictionary& entries_;
  const std::string& source_;
};

}  // namespace

std::string format_camera_model(const CameraModel& camera) {
  return fmt::format(
      "{{\n"
      "    'lensmodel':  '{}',\n\n"
      "    # fx fy cx cy in pixels, then the distortion\n"
      "    'intrinsics': {},\n\n"
      "    # rotation vector and translation, metres, that take a point of the world to the camera's frame\n"
      "    'extrinsics': {},\n\n"
      "    'imagersize': [ {}, {},],\n"
      "}}\n",
      to_string(camera.lens), list(camera.used_intrinsics()), list(camera_from_world(camera)), camera.width, camera.height);
}

Result<CameraModel> parse_camera_model(std::string_view text, const std::string& source) {
  const Result<PythonDictionary> entries = parse_python_dictionary(text);
  if (!entries) return entries.error().with_context(source);
  return Reader(*entries, source).camera();
}

Result<CameraModel> read_camera_model(const std::filesystem::path& path) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (failed) return Error{ErrorCode::not_found, fmt::format("{}: {}", path.string(), failed.message())};
  if (size > kLargestFile) return Error{ErrorCode::corrupt, fmt::format("{}: too large for a camera model", path.string())};
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return Error{ErrorCode::io, fmt::format("{}: cannot be read", path.string())};
  return parse_camera_model(text.view(), path.string());
}

Result<void> write_camera_model(const std::filesystem::path& path, const CameraModel& camera) {
  if (const Result<void> checked = check(camera); !checked) return checked.error().with_context(path.string());
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << format_camera_model(camera);
  file.flush();
  if (!file) return Error{ErrorCode::io, fmt::format("{}: cannot be written", path.string())};
  return {};
}

}  // namespace roseau::calib
