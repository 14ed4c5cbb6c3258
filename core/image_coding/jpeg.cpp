#include "core/image_coding/jpeg.h"

#include <turbojpeg.h>

#include <string>

#include "core/check.h"
#include "core/image_coding/png_format.h"

namespace roseau::image {

namespace {

using png::bytes_of;

TJPF turbo_format(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr8:
      return TJPF_BGR;
    case PixelFormat::rgb8:
      return TJPF_RGB;
    case PixelFormat::mono8:
    case PixelFormat::mono16:
      break;
  }
  return TJPF_GRAY;
}

TJSAMP subsampling(PixelFormat format) { return turbo_format(format) == TJPF_GRAY ? TJSAMP_GRAY : TJSAMP_420; }

/// A libjpeg-turbo object, made or found impossible to make.
class Handle {
 public:
  explicit Handle(tjhandle handle) : handle_(handle) { ROSEAU_CHECK(handle_ != nullptr); }
  ~Handle() { tjDestroy(handle_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  tjhandle get() const { return handle_; }
  Error error(ErrorCode code) const { return {code, std::string("JPEG: ") + tjGetErrorStr2(handle_)}; }

 private:
  tjhandle handle_;
};

}  // namespace

struct JpegEncoder::State {
  int quality;
  int transform;
  Handle turbo{tjInitCompress()};
};

JpegEncoder::JpegEncoder(int quality, Transform transform)
    : state_(new State{.quality = quality, .transform = transform == Transform::fast ? TJFLAG_FASTDCT : TJFLAG_ACCURATEDCT}) {
  ROSEAU_CHECK(quality >= 1 && quality <= 100);
}
JpegEncoder::~JpegEncoder() = default;

std::size_t JpegEncoder::buffer_bytes(std::uint32_t width, std::uint32_t height, PixelFormat format) {
  return tjBufSize(static_cast<int>(width), static_cast<int>(height), subsampling(format));
}

Result<std::size_t> JpegEncoder::encode(const PixelView& view, std::span<std::byte> out) {
  if (auto valid = check(view); !valid) return valid.error();
  if (view.format == PixelFormat::mono16) {
    return Error{ErrorCode::unsupported,
                 "JPEG holds 8 bits per pixel and the camera sends 16: store its pictures as png or raw"};
  }
  constexpr std::uint32_t kLongestSide_px = 65500;  // libjpeg's
  if (view.width > kLongestSide_px || view.height > kLongestSide_px) {
    return Error{ErrorCode::unsupported, "a picture's side is too long for JPEG: store it as png or raw"};
  }
  if (out.size() < buffer_bytes(view.width, view.height, view.format)) {
    return Error{ErrorCode::invalid_argument, "a buffer of " + std::to_string(out.size()) + " bytes is too small for a JPEG"};
  }
  unsigned char* buffer = bytes_of(out);
  unsigned long size = out.size();
  if (tjCompress2(state_->turbo.get(), bytes_of(view.pixels), static_cast<int>(view.width), static_cast<int>(view.stride),
                  static_cast<int>(view.height), turbo_format(view.format), &buffer, &size, subsampling(view.format),
                  state_->quality, state_->transform | TJFLAG_NOREALLOC) != 0) {
    return state_->turbo.error(ErrorCode::io);
  }
  return static_cast<std::size_t>(size);
}

bool is_jpeg(std::span<const std::byte> coded) {
  return coded.size() >= 3 && coded[0] == std::byte{0xFF} && coded[1] == std::byte{0xD8} && coded[2] == std::byte{0xFF};
}

Result<CodedInfo> read_jpeg_info(std::span<const std::byte> coded) {
  const Handle turbo(tjInitDecompress());
  int width = 0;
  int height = 0;
  int sampling = 0;
  int colours = 0;
  if (tjDecompressHeader3(turbo.get(), bytes_of(coded), coded.size(), &width, &height, &sampling, &colours) != 0) {
    return turbo.error(ErrorCode::corrupt);
  }
  if (colours == TJCS_CMYK || colours == TJCS_YCCK) {
    return Error{ErrorCode::unsupported, "a JPEG in printing colours (CMYK)"};
  }
  // A block of 64 pixels takes a bit at least.
  constexpr std::uint64_t kMostPixelsPerByte = 512;
  if (static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) / kMostPixelsPerByte > coded.size()) {
    return Error{ErrorCode::corrupt, "JPEG: it declares more pixels than it can hold"};
  }
  return CodedInfo{.coding = ImageStorage::jpeg,
                   .width = static_cast<std::uint32_t>(width),
                   .height = static_cast<std::uint32_t>(height),
                   .format = colours == TJCS_GRAY ? PixelFormat::mono8 : PixelFormat::rgb8};
}

struct JpegDecoder::State {
  Handle turbo{tjInitDecompress()};
};

JpegDecoder::JpegDecoder() : state_(std::make_unique<State>()) {}
JpegDecoder::~JpegDecoder() = default;

Result<void> JpegDecoder::decode(std::span<const std::byte> coded, const CodedInfo& info, std::span<std::byte> out) {
  ROSEAU_CHECK(out.size() == info.pixel_bytes());
  // A warning (a file that ends too early, bits that make no sense) is an error here: half a picture would be tracked as one.
  if (tjDecompress2(state_->turbo.get(), bytes_of(coded), coded.size(), bytes_of(out), static_cast<int>(info.width),
                    static_cast<int>(info.row_bytes()), static_cast<int>(info.height), turbo_format(info.format),
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0) {
    return state_->turbo.error(ErrorCode::corrupt);
  }
  return {};
}

}  // namespace roseau::image
