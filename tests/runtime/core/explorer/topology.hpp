// Who touches a topic, from which level, and how: what the explorer runs, and the slots it needs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stator::explorer {

// Written as one letter: r reads the newest, q reads the oldest unread, w publishes, b reads the
// newest and then publishes, B reads the oldest unread and then publishes. A number behind the
// letter is how often one activation publishes.
struct Role {
    char letter;

    bool reads() const { return letter != 'w'; }
    bool reads_queue() const { return letter == 'q' || letter == 'B'; }
    bool publishes() const { return letter == 'w' || letter == 'b' || letter == 'B'; }
};

struct TopicUser {
    unsigned level;  // from 1, the least urgent
    Role role;
    unsigned burst = 1;  // publications of one activation
};

struct Topology {
    std::vector<TopicUser> users;  // by level
    unsigned depth;

    std::string name() const;  // such as "1r 2b3 3q depth 2"
    unsigned top() const;      // highest publishing level
    bool takes_turns() const;  // as in the generated table
    unsigned ceiling() const;  // as in the generated table: 0 if one level publishes
    bool is_read_above(unsigned level) const;
    unsigned slots() const;  // the compiler's formula
};

// Parses "1r 2b3 3q".
Topology parse_topology(const std::string& text, unsigned depth);

// One user on each of `levels` levels, in every combination of roles with one to three publishers.
std::vector<Topology> all_topologies(unsigned levels, unsigned depth);
// The same for one or two levels, one of which two users of different roles share.
std::vector<Topology> shared_level_topologies(unsigned levels, unsigned depth);
// The same, where each publisher that reads publishes so often.
std::vector<Topology> with_burst(std::vector<Topology> topologies, unsigned burst);

}  // namespace stator::explorer
