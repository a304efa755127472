// Records in a memory that keeps its bytes without power, and that can be overwritten byte by byte:
// FRAM, or a file.
//
// Power may fail at any moment, also in the middle of a write. So each record has a slot, with a
// copy in either half of the memory; the copies are written one after the other, and each has a
// CRC. Whenever power fails, one copy at least is whole, the old record or the new one. Loading
// takes the newer one and writes the other one again. If one copy is damaged, nothing is lost; if
// both are, that record is, and no other. A write costs two slots: nothing is collected later.
// A record of no length takes the place of one that is removed, and its slot is free.
//
// What was read wrongly is not written over: a slot that is not good is read twice, and once more
// before a new record goes there; what is written is read back.
// docs/decisions/0015-records-in-two-copies.md
//
// One slot counts the starts that did not live long, for nodes that break a circle of restarts.
//
// The memory is a port, chosen at compile time; each call takes a bounded time, and false says that
// the memory did not do it:
//
//     bool read(uint32_t address, std::span<uint8_t> bytes);
//     bool write(uint32_t address, std::span<const uint8_t> bytes);
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "messages/stored_record.hpp"
#include "stator/crc32.hpp"

namespace stator::drivers::nonvolatile {

// A slot as it lies in the memory; little-endian.
struct RecordSlot {
    static constexpr unsigned kBytes = 32;

    uint32_t sequence;  // greater than that of every record before; 100 a second last 497 days
    uint32_t key;
    uint16_t place;  // of the slot, so that one that was written elsewhere is not good
    uint8_t kind;
    uint8_t length;
    std::array<uint8_t, 16> data;
    uint32_t crc;  // of all before it

    uint32_t sum() const { return crc32_bitwise(this, kBytes - sizeof crc); }
    bool is_good(unsigned at) const { return place == at && length <= data.size() && crc == sum(); }
    bool has_record_of(const RecordSlot& other) const {
        return key == other.key && kind == other.kind && length == other.length &&
               data == other.data;
    }
};
static_assert(sizeof(RecordSlot) == RecordSlot::kBytes);
static_assert(std::endian::native == std::endian::little);

template <class Port>
class RecordStore {
  public:
    static constexpr unsigned kMaxRecords = 255;
    static constexpr uint32_t kBytes = 2 * (kMaxRecords + 1) * RecordSlot::kBytes;

    enum class Load : uint8_t {
        kNothing,  // no record in this slot, or an outdated one
        kRecord,   // here it is; without length, if one was told before that is removed
        kFailed    // the memory did not answer; try again
    };
    enum class Keep : uint8_t { kKept, kFull, kFailed };

    explicit RecordStore(Port port) : port_(port) {}

    bool is_loaded() const { return loaded_ == kMaxRecords; }
    // Reads the next slot, and mends it if need be. Call until `is_loaded`, and no `keep` before.
    Load load_next(StoredRecord& record);
    // Replaces the record of the same kind and key; one without length removes it. What it holds
    // already is not written again.
    Keep keep(const StoredRecord& record);

    // How many starts before this one did not come to `forget_starts`; counts this one. False: the
    // memory did not answer; try again.
    bool count_start(unsigned& short_lives);
    bool forget_starts() { return write_starts(0); }

    unsigned records() const { return records_; }
    unsigned mended() const { return mended_; }
    unsigned damaged() const { return damaged_; }

  private:
    enum class Use : uint8_t { kFree, kUsed, kRemoved };
    struct Name {
        uint32_t key;
        uint8_t kind;
        Use use;
    };
    static constexpr uint32_t kHalf = kBytes / 2;
    static constexpr unsigned kStarts = kMaxRecords;  // the place of their count
    static constexpr uint8_t kKindOfStarts = 0xFF;

    static uint32_t address(unsigned copy, unsigned place) {
        return copy * kHalf + place * RecordSlot::kBytes;
    }
    bool read(unsigned copy, unsigned place, RecordSlot& slot) {
        std::array<uint8_t, RecordSlot::kBytes> bytes{};
        if (!port_.read(address(copy, place), bytes)) return false;
        slot = std::bit_cast<RecordSlot>(bytes);
        return true;
    }
    // One that is not good may have been read wrongly: then it is another one the second time.
    bool read_twice(unsigned copy, unsigned place, RecordSlot& slot) {
        RecordSlot again;
        if (!read(copy, place, slot)) return false;
        return slot.is_good(place) || (read(copy, place, again) && is_same(slot, again));
    }
    // And reads it back: a memory may take what it does not keep.
    bool write(unsigned copy, unsigned place, const RecordSlot& slot) {
        const auto bytes = std::bit_cast<std::array<uint8_t, RecordSlot::kBytes>>(slot);
        RecordSlot kept;
        return port_.write(address(copy, place), bytes) && read(copy, place, kept) &&
               is_same(kept, slot);
    }
    bool write_both(unsigned place, const RecordSlot& slot) {
        return write(0, place, slot) && write(1, place, slot);
    }
    static bool is_same(const RecordSlot& slot, const RecordSlot& other) {
        using Bytes = std::array<uint8_t, RecordSlot::kBytes>;
        return std::bit_cast<Bytes>(slot) == std::bit_cast<Bytes>(other);
    }
    // As it comes from the factory, or erased.
    static bool is_blank(const RecordSlot& slot) {
        const auto bytes = std::bit_cast<std::array<uint8_t, RecordSlot::kBytes>>(slot);
        const uint8_t first = bytes[0];
        return (first == 0 || first == 0xFF) &&
               std::all_of(bytes.begin(), bytes.end(), [=](uint8_t b) { return b == first; });
    }
    static bool is_newer(const RecordSlot& slot, const RecordSlot& other) {
        return slot.sequence > other.sequence;
    }
    // Its place; kMaxRecords: it is not there.
    unsigned find(uint32_t key, uint8_t kind) const {
        const auto is_it = [=](const Name& name) {
            return (name.use == Use::kUsed || name.use == Use::kRemoved) && name.key == key &&
                   name.kind == kind;
        };
        const auto* const found = std::find_if(names_.begin(), names_.end(), is_it);
        return static_cast<unsigned>(found - names_.begin());
    }
    unsigned find_free() const {
        const auto* const found = std::find_if(
            names_.begin(), names_.end(), [](const Name& name) { return name.use != Use::kUsed; });
        return static_cast<unsigned>(found - names_.begin());
    }
    void use(unsigned place, const RecordSlot& slot) {
        const Use use = slot.length == 0 ? Use::kRemoved : Use::kUsed;
        if (names_[place].use == Use::kUsed) --records_;
        if (use == Use::kUsed) ++records_;
        names_[place] = {slot.key, slot.kind, use};
    }
    void forget(unsigned place) {
        if (names_[place].use == Use::kUsed) --records_;
        names_[place] = {0, 0, Use::kFree};
    }
    bool write_starts(uint32_t count);
    Load take(unsigned place, const RecordSlot& slot, StoredRecord& record);
    Load skip(const RecordSlot& second);

    Port port_;
    std::array<Name, kMaxRecords> names_{};  // of the records, by place
    unsigned loaded_ = 0;                    // slots
    unsigned records_ = 0;
    unsigned mended_ = 0;
    unsigned damaged_ = 0;
    uint32_t sequence_ = 0;  // the newest
    uint32_t starts_sequence_ = 0;
};

// Neither copy is good. A second copy that was never written says that the first one was cut off:
// this record was never reported as kept.
template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::skip(const RecordSlot& second) {
    ++loaded_;
    if (!is_blank(second)) ++damaged_;
    return Load::kNothing;
}

// Two slots have records of one name if one was unreadable when the other was written. The newer
// one counts. The other one goes, or it would come back once the newer one is removed.
template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::take(unsigned place, const RecordSlot& slot,
                                                         StoredRecord& record) {
    const unsigned other = find(slot.key, slot.kind);
    const bool was_told = other < kMaxRecords && names_[other].use == Use::kUsed;
    if (other < kMaxRecords) {
        RecordSlot there;
        if (!read(0, other, there)) return Load::kFailed;
        const bool is_older = !is_newer(slot, there);
        if (!write_both(is_older ? place : other, RecordSlot{})) return Load::kFailed;
        if (is_older) {
            ++loaded_;
            return Load::kNothing;
        }
        forget(other);
    }
    use(place, slot);
    ++loaded_;
    record = {.key = slot.key,
              .kind = static_cast<StoredRecord::Kind>(slot.kind),
              .length = slot.length,
              .data = slot.data};
    return slot.length == 0 && !was_told ? Load::kNothing : Load::kRecord;
}

template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::load_next(StoredRecord& record) {
    const unsigned place = loaded_;
    std::array<RecordSlot, 2> copies;
    if (!read_twice(0, place, copies[0]) || !read_twice(1, place, copies[1])) return Load::kFailed;
    const bool first_is_good = copies[0].is_good(place);
    const bool second_is_good = copies[1].is_good(place);
    if (!first_is_good && !second_is_good) return skip(copies[1]);
    const bool is_second = !first_is_good || (second_is_good && is_newer(copies[1], copies[0]));
    const RecordSlot& newest = copies[is_second ? 1 : 0];
    if (!first_is_good || !second_is_good || copies[0].sequence != copies[1].sequence) {
        if (!write(is_second ? 0 : 1, place, newest)) return Load::kFailed;
        ++mended_;
    }
    sequence_ = std::max(sequence_, newest.sequence);
    return take(place, newest, record);
}

template <class Port>
typename RecordStore<Port>::Keep RecordStore<Port>::keep(const StoredRecord& record) {
    RecordSlot slot{.sequence = sequence_ + 1,
                    .key = record.key,
                    .place = 0,
                    .kind = static_cast<uint8_t>(record.kind),
                    .length = record.length,
                    .data = record.data,
                    .crc = 0};
    if (slot.length > slot.data.size()) slot.length = static_cast<uint8_t>(slot.data.size());
    std::fill(slot.data.begin() + slot.length, slot.data.end(), uint8_t{0});
    unsigned place = find(slot.key, slot.kind);
    const bool is_new = place == kMaxRecords;
    if (is_new && slot.length == 0) return Keep::kKept;
    if (is_new) place = find_free();
    if (place == kMaxRecords) return Keep::kFull;
    RecordSlot now;
    if (!read(0, place, now)) return Keep::kFailed;
    if (!is_new && now.is_good(place) && now.has_record_of(slot)) return Keep::kKept;
    // A record where none was found at the start was not read then: it stays, and the next try goes
    // elsewhere.
    if (is_new && now.is_good(place) && now.length != 0) {
        use(place, now);
        return Keep::kFailed;
    }
    slot.place = static_cast<uint16_t>(place);
    slot.crc = slot.sum();
    sequence_ = slot.sequence;
    if (!write(0, place, slot)) return Keep::kFailed;
    use(place, slot);
    return write(1, place, slot) ? Keep::kKept : Keep::kFailed;
}

template <class Port>
bool RecordStore<Port>::count_start(unsigned& short_lives) {
    uint32_t newest = 0;
    for (unsigned copy = 0; copy < 2; ++copy) {
        RecordSlot slot;
        if (!read_twice(copy, kStarts, slot)) return false;
        if (!slot.is_good(kStarts) || slot.kind != kKindOfStarts) continue;
        if (slot.sequence >= starts_sequence_) {
            starts_sequence_ = slot.sequence;
            newest = slot.key;
        }
    }
    short_lives = newest;
    return write_starts(newest + 1);
}

template <class Port>
bool RecordStore<Port>::write_starts(uint32_t count) {
    RecordSlot slot{.sequence = ++starts_sequence_,
                    .key = count,
                    .place = kStarts,
                    .kind = kKindOfStarts,
                    .length = 0,
                    .data = {},
                    .crc = 0};
    slot.crc = slot.sum();
    return write_both(kStarts, slot);
}

}  // namespace stator::drivers::nonvolatile
