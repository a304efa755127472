// A set of hashes: open addressing, as the search does little else than to ask it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stator::explorer {

class KnownStates {
  public:
    KnownStates() : places_(1024) {}
    std::size_t size() const { return size_; }

    // True if the state is new.
    bool insert(uint64_t hash) {
        if (hash == kFree) hash = 1;
        if (2 * size_ >= places_.size()) grow();
        if (!put(hash)) return false;
        ++size_;
        return true;
    }

  private:
    static constexpr uint64_t kFree = 0;

    bool put(uint64_t hash) {
        const std::size_t mask = places_.size() - 1;
        std::size_t place = hash & mask;
        while (places_[place] != kFree) {
            if (places_[place] == hash) return false;
            place = (place + 1) & mask;
        }
        places_[place] = hash;
        return true;
    }
    void grow() {
        std::vector<uint64_t> old(places_.size() * 4);
        old.swap(places_);
        for (const uint64_t hash : old) {
            if (hash != kFree) put(hash);
        }
    }

    std::vector<uint64_t> places_;
    std::size_t size_ = 0;
};

}  // namespace stator::explorer
