#include "daemon/digest.h"

#include <openssl/evp.h>

#include <array>
#include <cstdint>

#include "core/check.h"
#include "schema/conversion.h"

namespace roseau::daemon {

namespace {

struct ContextDelete {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using Context = std::unique_ptr<EVP_MD_CTX, ContextDelete>;

}  // namespace

struct Digest::State {
  Context context{EVP_MD_CTX_new()};

  void update(const void* bytes, std::size_t size) { ROSEAU_CHECK(EVP_DigestUpdate(context.get(), bytes, size) == 1); }
  template <class T>
  void update_number(T number) {
    // Little-endian whatever the machine, so that digests of two machines can be compared.
    std::array<unsigned char, sizeof(T)> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<unsigned char>(static_cast<std::uint64_t>(number) >> (8 * i));
    }
    update(bytes.data(), bytes.size());
  }
};

Digest::Digest() : state_(std::make_unique<State>()) {
  ROSEAU_CHECK(EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) == 1);
}

Digest::~Digest() = default;

void Digest::add(const Sample& sample, const StreamTable& streams) {
  const StreamInfo& stream = streams.info(sample.header.stream);
  if (stream.role != StreamRole::derived) return;
  schema::serialize(sample, streams, message_);
  // Lengths go in too: otherwise the end of one field and the start of the next could trade bytes unseen.
  state_->update_number(static_cast<std::uint32_t>(stream.topic.size()));
  state_->update(stream.topic.data(), stream.topic.size());
  state_->update_number(to_ns(sample.header.sample_time));
  state_->update_number(static_cast<std::uint64_t>(message_.size()));
  state_->update(message_.data(), message_.size());
}

std::string Digest::hex() const {
  const Context copy(EVP_MD_CTX_new());
  std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
  unsigned int size = 0;
  ROSEAU_CHECK(EVP_MD_CTX_copy_ex(copy.get(), state_->context.get()) == 1);
  ROSEAU_CHECK(EVP_DigestFinal_ex(copy.get(), bytes.data(), &size) == 1);
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[bytes[i] >> 4U];
    text += kDigits[bytes[i] & 15U];
  }
  return text;
}

}  // namespace roseau::daemon
