"""The ledger of tiles: what it takes from a store, and that no tile goes back."""

from worker.basins.ledger import Ledger
from worker.stores.layout import TileState


def test_no_tile_goes_back(store):
    ledger = Ledger(store)
    assert ledger.basins == 1 and ledger.mapped(0) == {0, 1, 2, 3}
    ledger.set_state(0, TileState.COMPUTED)
    ledger.set_state(range(1, 3), TileState.PENDING)
    assert (ledger.states == TileState.ASSEMBLED).all()


def test_a_basin_is_complete_if_ledger_and_table_say_so(store):
    states = store.read_ledger().copy()
    states[3] = TileState.PENDING
    store.write_ledger(states)
    ledger = Ledger(store)
    assert ledger.basins == 0 and ledger.mapped(0) == {0, 1, 2}
    assert ledger.table.motions == []
    ledger.set_state(3, TileState.COMPUTED)
    ledger.save()
    assert store.read_ledger().tolist() == [3, 3, 3, 2]
