#include "recorder/image_storage.h"

#include "recorder/format/topics.h"

namespace roseau::recorder {

ImageStorage storage_of(const Sample& sample, const StreamInfo& stream, const RecorderOptions& options) {
  const auto* frame = std::get_if<Frame>(&sample.payload);
  if (frame == nullptr) return ImageStorage::raw;
  const auto wanted = options.image_storage.find(stream.device);
  const ImageStorage storage = wanted == options.image_storage.end() ? mcap::storage_of(stream) : wanted->second;
  // What comes coded is stored so, or pixels would be stored that take more room and are not better.
  return storage == ImageStorage::raw && frame->coded ? frame->coded.format : storage;
}

StreamInfo stored_stream(const Sample& sample, const StreamInfo& stream, const RecorderOptions& options) {
  StreamInfo stored = stream;
  const ImageStorage storage = storage_of(sample, stream, options);
  const std::string key(mcap::kStorageKey);
  if (storage == ImageStorage::raw) stored.metadata.erase(key);
  // What another program called its coding stays as it is, unless asked otherwise.
  else if (mcap::storage_of(stream) != storage)
    stored.metadata[key] = to_string(storage);
  return stored;
}

}  // namespace roseau::recorder
