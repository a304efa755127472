// The key of signatures in a record store. Its records are published nowhere, as topics are
// recorded: it goes from here to the lines by a way of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "messages/stored_record.hpp"
#include "stator/mavlink/shared_key.hpp"

namespace stator::drivers::nonvolatile {

// A key takes two records, and has two places to take turns; one more record, the head, names the
// place that counts and the key's fingerprint. It is written last, so a power cut at any moment
// leaves the old key or the new one. A head whose key is not there says that the key is lost.
class KeyKeeper {
  public:
    // Each record of a key, while they are loaded.
    void take(const StoredRecord& record) {
        if (record.key == kHead) {
            head_.reset();
            if (record.length != 0) head_ = record;
            return;
        }
        const uint32_t half = record.key - kFirstHalf;
        if (half >= 2 * kPlaces) return;
        auto& bytes = places_[half / 2];
        std::copy_n(record.data.begin(), kHalfBytes,
                    bytes.begin() + static_cast<std::ptrdiff_t>(half % 2 * kHalfBytes));
    }
    // Once all are loaded. A key that was given at the start counts in place of the kept one.
    void share(mav::SharedKey& shared) {
        // None writes before it is known which one there is.
        if (shared.version() == 0) static_cast<void>(shared.write(found()));
        version_ = shared.version();
    }
    // The next record to write, if the key has changed; none: there is nothing to do.
    std::optional<StoredRecord> next(const mav::SharedKey& shared) {
        if (step_ == kDone && shared.read(version_, wanted_)) begin();
        if (step_ == kDone) return {};
        return wanted_.state == mav::SigningKey::State::kSet ? of_key() : of_none();
    }
    // The record is kept.
    void go_on() {
        if (++step_ == kDone && wanted_.state == mav::SigningKey::State::kSet) head_ = head();
    }
    // It never will be.
    void give_up() { step_ = kDone; }

  private:
    static constexpr uint32_t kHead = 0;
    static constexpr uint32_t kFirstHalf = 1;
    static constexpr unsigned kPlaces = 2;
    static constexpr uint8_t kHalfBytes = mav::kKeyBytes / 2;
    static constexpr unsigned kDone = 5;  // steps

    unsigned place() const { return head_ ? head_->data[0] % kPlaces : 1; }
    mav::SigningKey found() const {
        if (!head_) return {};
        const mav::SigningKey key{.state = mav::SigningKey::State::kSet, .bytes = places_[place()]};
        const auto fingerprint = mav::fingerprint_of(key.bytes);
        const bool is_it =
            std::equal(fingerprint.begin(), fingerprint.end(), head_->data.begin() + 1);
        return is_it ? key : mav::SigningKey{.state = mav::SigningKey::State::kLost};
    }
    void begin() {
        step_ = 0;
        new_place_ = 1 - place();
        if (wanted_.state == mav::SigningKey::State::kSet) places_[new_place_] = wanted_.bytes;
    }
    static StoredRecord record(uint32_t key) {
        return {.key = key, .kind = StoredRecord::Kind::kSigningKey};
    }
    StoredRecord half_of(unsigned place, unsigned half) const {
        StoredRecord result = record(kFirstHalf + 2 * place + half);
        result.length = kHalfBytes;
        std::copy_n(places_[place].begin() + static_cast<std::ptrdiff_t>(half * kHalfBytes),
                    kHalfBytes, result.data.begin());
        return result;
    }
    StoredRecord head() const {
        StoredRecord result = record(kHead);
        result.data[0] = static_cast<uint8_t>(new_place_);
        const auto fingerprint = mav::fingerprint_of(wanted_.bytes);
        std::copy(fingerprint.begin(), fingerprint.end(), result.data.begin() + 1);
        result.length = 1 + mav::kFingerprintBytes;
        return result;
    }
    // The new key, the head, and then nothing of the old one.
    StoredRecord of_key() const {
        if (step_ < 2) return half_of(new_place_, step_);
        if (step_ == 2) return head();
        return record(kFirstHalf + 2 * (1 - new_place_) + (step_ - 3));
    }
    StoredRecord of_none() {
        if (step_ == 0) head_.reset();
        return record(step_);
    }

    std::array<mav::SigningKeyBytes, kPlaces> places_{};
    std::optional<StoredRecord> head_;
    mav::SigningKey wanted_;
    uint32_t version_ = 0;
    unsigned new_place_ = 0;
    unsigned step_ = kDone;
};

}  // namespace stator::drivers::nonvolatile
