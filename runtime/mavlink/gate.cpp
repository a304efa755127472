// Between a line and what reads and writes it.
#include "stator/mavlink/gate.hpp"

#include "mavlink/messages.hpp"

namespace stator::mav {

namespace {

// Of SETUP_SIGNING, in the payload.
constexpr std::size_t kKeyAt = 10;

}  // namespace

void Gate::follow(uint64_t now_us) {
    if (!shared_.read(version_, key_)) return;
    settled_us_ = now_us + kSettles_us;
    passing_ = {};
}

bool Gate::is_good(const Frame& frame) const {
    if (key_.state != SigningKey::State::kSet) return false;
    Sha256 sha;
    sha.add(key_.bytes);
    sha.add(frame.bytes.first(frame.bytes.size() - kHashBytes));
    const auto hash = sha.finish();
    // Each byte, so that the time does not tell how many are right.
    uint8_t difference = 0;
    for (std::size_t i = 0; i < kHashBytes; ++i) {
        const uint8_t sent = frame.bytes[frame.bytes.size() - kHashBytes + i];
        difference = static_cast<uint8_t>(difference | (hash[i] ^ sent));
    }
    return difference == 0;
}

void Gate::keep_key_back(const Frame& frame) {
    const auto payload =
        frame.payload.size() > kKeyAt ? frame.payload.subspan(kKeyAt) : std::span<const uint8_t>();
    offered_ = {};
    std::copy_n(payload.begin(), std::min(payload.size(), offered_.size()), offered_.begin());
    Fingerprint fingerprint{};
    if (offered_ != SigningKeyBytes{}) fingerprint = fingerprint_of(offered_);
    const std::span<uint8_t> bytes = parser_.change();
    const std::size_t end = kHeaderBytes + frame.payload.size();
    for (std::size_t i = kHeaderBytes + kKeyAt; i < end; ++i) {
        const std::size_t place = i - kHeaderBytes - kKeyAt;
        bytes[i] = place < fingerprint.size() ? fingerprint[place] : uint8_t{0};
    }
    const uint16_t crc =
        crc16(crc16(kCrcSeed, std::span<const uint8_t>(bytes).first(end).subspan(1)),
              SetupSigning::kCrcExtra);
    bytes[end] = static_cast<uint8_t>(crc);
    bytes[end + 1] = static_cast<uint8_t>(crc >> 8);
}

bool Gate::passes(const Frame& frame) {
    if (signs() && frame.is_signed && !is_good(frame)) return false;
    if (frame.id == SetupSigning::kId) keep_key_back(frame);
    return true;
}

// What says how long the frame is, and whether it is signed.
void Gate::take_head(std::size_t at, uint8_t byte) {
    if (at == 1) end_ = kHeaderBytes + byte + kCrcBytes;
    if (at != 2 || byte != kIsSigned) return;
    is_signed_ = key_.state == SigningKey::State::kSet;
    end_ += kSignatureBytes;
    sha_ = Sha256();
    sha_.add(key_.bytes);
    const std::array<uint8_t, 2> before{
        kStart, static_cast<uint8_t>(end_ - kHeaderBytes - kCrcBytes - kSignatureBytes)};
    sha_.add(before);
}

void Gate::sign(std::span<uint8_t> piece, bool ends) {
    for (uint8_t& byte : piece) {
        if (at_ == 0) is_signed_ = false;
        if (at_ == 1 || at_ == 2) take_head(at_, byte);
        const bool is_of_hash = is_signed_ && at_ + kHashBytes >= end_;
        if (is_signed_ && !is_of_hash) sha_.add({&byte, 1});
        if (is_of_hash && at_ + kHashBytes == end_) {
            const auto digest = sha_.finish();
            std::copy_n(digest.begin(), hash_.size(), hash_.begin());
        }
        if (is_of_hash) byte = hash_[at_ + kHashBytes - end_];
        ++at_;
        if (at_ > 2 && at_ == end_) at_ = 0;
    }
    if (ends) at_ = 0;
}

void Gate::adopt(std::span<const uint8_t> fingerprint) {
    SigningKey key;
    if (!fingerprint.empty()) {
        if (!std::ranges::equal(fingerprint, fingerprint_of(offered_))) return;
        key = {.state = SigningKey::State::kSet, .bytes = offered_};
    }
    if (shared_.write(key)) offered_ = {};
}

}  // namespace stator::mav
