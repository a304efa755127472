// The file of all parameters, piece by piece.
#include "pack.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <string_view>

namespace stator::apps::parameters {

namespace {

constexpr std::size_t kMaxIdBytes = 16;
constexpr std::size_t kValueBytes = sizeof(ParameterBits);
// Type, lengths, letters, value, default.
constexpr std::size_t kMaxEntryBytes = 2 + kMaxIdBytes + 2 * kValueBytes;

using Bytes = std::array<uint8_t, kMaxEntryBytes>;

// Takes the bytes of a file one after the other, and keeps those of one piece.
class PieceWriter {
  public:
    PieceWriter(FilePiece& piece, const FileRequest& request)
        : piece_(piece),
          begin_(request.offset),
          length_(std::min<std::size_t>(request.length, piece.data.size())) {}

    uint32_t bytes() const { return place_; }
    void put(std::span<const uint8_t> bytes) {
        for (const uint8_t byte : bytes) {
            const uint32_t at = place_++;
            if (at < begin_ || at - begin_ >= length_) continue;
            piece_.data[at - begin_] = byte;
            piece_.length = static_cast<uint8_t>(at - begin_ + 1);
        }
    }

  private:
    FilePiece& piece_;
    uint32_t begin_;
    std::size_t length_;
    uint32_t place_ = 0;
};

// What the file begins with. `entries` of `all` parameters are in it.
std::array<uint8_t, 6> head_of(std::size_t entries, std::size_t all, bool with_defaults) {
    constexpr uint16_t kMagic = 0x671B;
    const std::array words{static_cast<uint16_t>(kMagic + (with_defaults ? 1 : 0)),
                           static_cast<uint16_t>(entries), static_cast<uint16_t>(all)};
    std::array<uint8_t, 6> head{};
    std::memcpy(head.data(), words.data(), head.size());
    return head;
}

// One parameter, without the letters that its id shares with the one before. A default follows only
// where it differs from the value. ArduPilot pads with zeros, so that no value lies in two reads
// and changes between them; here the pieces of one file have one version.
std::span<const uint8_t> entry_of(Bytes& bytes, std::string_view before, const ParameterRow& row,
                                  ParameterBits value, bool with_defaults) {
    constexpr uint8_t kInt32 = 3;
    constexpr uint8_t kFloat = 4;
    constexpr uint8_t kHasDefault = 0x10;
    constexpr std::size_t kMaxShared = 15;
    const std::string_view id = std::string_view(row.is.id).substr(0, kMaxIdBytes);
    const std::size_t limit = std::min({before.size(), id.size() - 1, kMaxShared});
    std::size_t shared = 0;
    while (shared < limit && before[shared] == id[shared]) ++shared;
    std::string_view letters = id;
    letters.remove_prefix(shared);
    const bool has_default = with_defaults && row.standard != value;
    uint8_t* at = bytes.data();
    *at++ = static_cast<uint8_t>((row.type == ParameterType::kFloat ? kFloat : kInt32) |
                                 (has_default ? kHasDefault : 0));
    *at++ = static_cast<uint8_t>(shared | (letters.size() - 1) << 4);
    at = std::ranges::copy(letters, at).out;
    std::memcpy(at, &value, kValueBytes);
    at += kValueBytes;
    if (has_default) {
        std::memcpy(at, &row.standard, kValueBytes);
        at += kValueBytes;
    }
    return {bytes.data(), at};
}

// FNV-1a, by whole values.
uint32_t mixed(uint32_t hash, ParameterBits value) {
    return (hash ^ value) * 0x01000193U;
}

}  // namespace

FilePiece read_pack(const ParameterPort& parameters, const FileRequest& request) {
    FilePiece piece{.tag = request.tag};
    const auto all = parameters.rows();
    const std::size_t first = std::min<std::size_t>(request.first, all.size());
    const auto rows = all.subspan(first, std::min<std::size_t>(request.count, all.size() - first));
    PieceWriter writer(piece, request);
    writer.put(head_of(rows.size(), all.size(), request.with_defaults));
    std::string_view before;
    uint32_t hash = 0x811C9DC5U;
    Bytes bytes;
    for (const ParameterRow& row : rows) {
        const ParameterBits value = parameters.value(row);
        hash = mixed(hash, value);
        writer.put(entry_of(bytes, before, row, value, request.with_defaults));
        before = row.is.id;
    }
    piece.bytes = writer.bytes();
    piece.version = hash;
    return piece;
}

}  // namespace stator::apps::parameters
