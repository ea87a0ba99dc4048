// SPDX-License-Identifier: Apache-2.0
#include "app/machines.hpp"

#include "acquisition/replay_machine.hpp"

namespace cmm::app {

drivers::Registry machine_registry() {
    auto registry = drivers::standard_registry();
    registry.add({"replay", "a run file played again (docs/cli.md)", &acquisition::make_replay_machine});
    return registry;
}

}  // namespace cmm::app
