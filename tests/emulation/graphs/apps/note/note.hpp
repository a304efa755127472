// Notes that it ran.
#pragma once

#include "../../journal.hpp"
#include "note_ports.hpp"

namespace stator::apps::note {

class Note {
  public:
    void step(NotePorts& ports) { journal::note(ports.params->id); }
};

}  // namespace stator::apps::note
