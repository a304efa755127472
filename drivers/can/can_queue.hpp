// Frames that wait to be sent, the most urgent first, as the bus itself would choose.
#pragma once

#include <array>
#include <cstdint>

namespace stator {

// Holds `kCapacity` items with `frame.id`, `frame.extended` and `queued_us`. Lower identifiers go
// first, equal ones in their order: so frames of one transfer keep theirs.
template <class Item, unsigned kCapacity>
class CanQueue {
  public:
    bool is_empty() const { return count_ == 0; }
    unsigned count() const { return count_; }
    const Item& first() const { return items_[0]; }

    // False if a frame had to go: the least urgent, which may be this one.
    [[nodiscard]] bool add(const Item& item) {
        unsigned place = count_;
        while (place > 0 && rank(item) < rank(items_[place - 1])) --place;
        const bool room = count_ < kCapacity;
        if (place == kCapacity) return false;
        const unsigned last = room ? count_++ : kCapacity - 1;
        for (unsigned i = last; i > place; --i) items_[i] = items_[i - 1];
        items_[place] = item;
        return room;
    }
    void remove_first() { remove(0); }
    // How many had waited since before `oldest_us` and are gone.
    unsigned remove_older(uint64_t oldest_us) {
        const unsigned before = count_;
        for (unsigned i = count_; i > 0; --i) {
            if (items_[i - 1].queued_us < oldest_us) remove(i - 1);
        }
        return before - count_;
    }

  private:
    // In the bus's arbitration, 11 bits come first, and a short identifier wins over a long one
    // that begins alike.
    static uint32_t rank(const Item& item) {
        return item.frame.extended
                   ? ((item.frame.id & 0x1FFC0000) << 1) | 0x40000 | (item.frame.id & 0x3FFFF)
                   : item.frame.id << 19;
    }
    void remove(unsigned place) {
        --count_;
        for (unsigned i = place; i < count_; ++i) items_[i] = items_[i + 1];
    }

    std::array<Item, kCapacity> items_{};
    unsigned count_ = 0;
};

}  // namespace stator
