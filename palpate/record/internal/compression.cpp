#include "palpate/record/internal/compression.h"

#include <zstd.h>

#include <new>

namespace palpate::record {

namespace {
constexpr int kLevel = 1;
}

struct Compressor::Context {
  ZSTD_CCtx* zstd = ZSTD_createCCtx();
  std::string packed;
  Context() {
    if (zstd == nullptr) throw std::bad_alloc();
  }
  ~Context() { ZSTD_freeCCtx(zstd); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

Compressor::Compressor() : context_(std::make_unique<Context>()) {}
Compressor::~Compressor() = default;
Compressor::Compressor(Compressor&&) noexcept = default;
Compressor& Compressor::operator=(Compressor&&) noexcept = default;

std::string_view Compressor::compress(std::string_view bytes) {
  auto& packed = context_->packed;
  const std::size_t room = ZSTD_compressBound(bytes.size());
  if (packed.size() < room) packed.resize(room);
  const std::size_t size =
      ZSTD_compressCCtx(context_->zstd, packed.data(), packed.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the only reason left where there is room
  return std::string_view(packed).substr(0, size);
}

struct Decompressor::Context {
  ZSTD_DCtx* zstd = ZSTD_createDCtx();
  // Not initialised: pages that nobody writes to take no memory.
  std::unique_ptr<char[]> room;
  std::uint64_t size = 0;
  Context() {
    if (zstd == nullptr) throw std::bad_alloc();
  }
  ~Context() { ZSTD_freeDCtx(zstd); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

Decompressor::Decompressor() : context_(std::make_unique<Context>()) {}
Decompressor::~Decompressor() = default;
Decompressor::Decompressor(Decompressor&&) noexcept = default;
Decompressor& Decompressor::operator=(Decompressor&&) noexcept = default;

std::optional<std::string_view> Decompressor::decompress(std::string_view bytes, std::uint64_t size) {
  // A frame says how much it holds; where that is another number, nothing is unpacked.
  const auto told = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (told == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
  if (told != ZSTD_CONTENTSIZE_UNKNOWN && told > size) return std::nullopt;
  auto& room = context_->room;
  if (context_->size < size || !room) {
    room.reset();
    room.reset(new char[size > 0 ? size : 1]);
    context_->size = size;
  }
  const std::size_t got = ZSTD_decompressDCtx(context_->zstd, room.get(), size, bytes.data(), bytes.size());
  if (ZSTD_isError(got) != 0 || got != size) return std::nullopt;
  return std::string_view(room.get(), size);
}

}  // namespace palpate::record
