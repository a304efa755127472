// What the stations of a graph saw, in order; one journal a process.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stator::apps::station::journal {

struct Entry {
    int id;
    uint32_t activation;  // of this node object, from 1
    uint64_t now_us;
    uint64_t clock_us;
    uint32_t timers;
    bool has_a;
    bool a_is_new;
    uint32_t a_value;
    uint32_t a_source;
    uint32_t a_lost;
    std::vector<uint32_t> b_values;
    uint32_t b_lost;
};

extern std::vector<Entry> entries;
// "+3" where an activation of station 3 begins, "-3" where it ends.
extern std::string order;
extern unsigned torn;  // samples that were not whole, or changed during an activation

inline std::vector<Entry> of(int id) {
    std::vector<Entry> found;
    for (const Entry& entry : entries) {
        if (entry.id == id) found.push_back(entry);
    }
    return found;
}

}  // namespace stator::apps::station::journal
