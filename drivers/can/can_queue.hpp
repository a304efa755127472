// Frames that wait to be sent, the most urgent first, as the bus itself would choose.
#pragma once

#include <array>
#include <cstdint>

namespace stator::drivers::can {

// Holds `kCapacity` frames with `timestamp`, `id` and `extended`. Lower identifiers go first, equal
// ones in their order: so frames of one transfer keep theirs.
template <class Frame, unsigned kCapacity>
class CanQueue {
  public:
    bool is_empty() const { return count_ == 0; }
    unsigned count() const { return count_; }
    const Frame& first() const { return frames_[0]; }

    // False if a frame had to go: the least urgent, which may be this one.
    [[nodiscard]] bool add(const Frame& frame) {
        unsigned place = count_;
        while (place > 0 && rank(frame) < rank(frames_[place - 1])) --place;
        return insert(frame, place);
    }
    // The same for one that was first already: it goes before those of its identifier.
    [[nodiscard]] bool put_back(const Frame& frame) {
        unsigned place = count_;
        while (place > 0 && rank(frame) <= rank(frames_[place - 1])) --place;
        return insert(frame, place);
    }
    void remove_first() { remove(0); }
    // How many are from before `oldest_us` and are gone.
    unsigned remove_older(uint64_t oldest_us) {
        const unsigned before = count_;
        for (unsigned i = count_; i > 0; --i) {
            if (frames_[i - 1].timestamp < oldest_us) remove(i - 1);
        }
        return before - count_;
    }

  private:
    // In the bus's arbitration, 11 bits come first, and a short identifier wins over a long one
    // that begins alike.
    static uint32_t rank(const Frame& frame) {
        return frame.extended ? ((frame.id & 0x1FFC0000) << 1) | 0x40000 | (frame.id & 0x3FFFF)
                              : frame.id << 19;
    }
    bool insert(const Frame& frame, unsigned place) {
        const bool room = count_ < kCapacity;
        if (place == kCapacity) return false;
        const unsigned last = room ? count_++ : kCapacity - 1;
        for (unsigned i = last; i > place; --i) frames_[i] = frames_[i - 1];
        frames_[place] = frame;
        return room;
    }
    void remove(unsigned place) {
        --count_;
        for (unsigned i = place; i < count_; ++i) frames_[i] = frames_[i + 1];
    }

    std::array<Frame, kCapacity> frames_{};
    unsigned count_ = 0;
};

}  // namespace stator::drivers::can
