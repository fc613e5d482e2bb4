"""Every door by which files of others come in; :mod:`step_modules` adds those that need torch."""

import data
import folders
import mutations
import speech
import work
from door import Door

DOORS = {
    door.name: door
    for door in (
        Door("wave", speech.waves, speech.listen),
        Door("film", speech.films, speech.listen),
        Door("transcript", speech.scripts, speech.read_words, mutations.of_json),
        Door("data-transcript", speech.data_words, speech.read_data_words, mutations.of_json),
        Door("letters", lambda: [(".json", b'{"sch": "SH", "a": "AA", "ch": "K"}')], speech.letters, mutations.of_json),
        Door("vocabulary", speech.vocabularies, speech.read_vocabulary, mutations.of_json),
        Door("clip", speech.clips, speech.read_clip, folders.damage_file),
        Door("turns", speech.dialogues, speech.read_turns, mutations.of_text),
        Door("mouth-cues", data.cues, data.read_cues, mutations.of_json),
        Door("face-map", data.face_maps, data.read_face_map, mutations.of_json),
        Door("map", work.maps, work.read_map, mutations.of_json),
        Door("manifest", work.manifests, work.read_manifest, mutations.of_lines),
        Door("curves", work.curves, work.read_curves, mutations.of_json),
        Door("edits", work.edits, work.read_edits, mutations.of_json),
        Door("sheet", work.sheets, work.read_sheet, mutations.of_json),
        Door("study", work.study_files, work.read_study, mutations.of_json),
        Door("record", work.records, work.read_record, mutations.of_json),
        Door("cache", lambda: [(".json", b'[["a", 0.0, 1.0]]')], work.read_cache, mutations.of_json),
        Door("protocol", work.lines, work.serve_line, mutations.of_json),
        Door("motion", data.motions, data.read_motion, mutations.of_arrays),
        Door("performance", data.performances, data.read_performance, data.damage_performance),
        Door("vectors", data.tables, data.read_table, data.damage_table),
        Door("pickle", data.pickles, data.read_pickle),
        *folders.DOORS,
    )
}  # fmt: skip
