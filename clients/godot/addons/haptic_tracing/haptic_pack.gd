## Plays a baked pack, as [i]Export for an Engine[/i] writes it, without a server: the tracks of the bake, and whatever blows and
## one-shots happen, from the table of the bake.
class_name HapticPack
extends RefCounted

## What a pack cannot do.
var limits := []
## The names of the listeners.
var listeners := []
## The blows of the bake: {"objects": [A, B], "time": s, "position": Vector3, "energy": J, ...}.
var blows := []
## The sources that played once in the bake: {"source": name, "time": s, ...}.
var one_shots := []
## Samples per second.
var sample_rate := 0.0
## Whether the tracks begin again at their end.
var loops := false
## Seconds that have been played.
var time: float:
	get: return _played / sample_rate

var _tracks := {}
var _shots := {}
var _materials := {}
var _ceilings := {}
var _recent := {}
var _sounds := []
var _length := 0
var _played := 0


## The pack in a file; null, with an error, if it is not one.
static func open(path: String) -> HapticPack:
	var form: Variant = JSON.parse_string(FileAccess.get_file_as_string(path))
	if not form is Dictionary or form.get("format") != "haptic-pack" or not str(form.get("version")).begins_with("1."):
		push_error("%s is not a haptic pack of version 1" % path)
		return null
	var pack := new()
	pack._read(form)
	return pack


## The material of an object that comes at run time, for its blows.
func set_material(object_name: String, material: String) -> void:
	_materials[object_name] = material


## Two objects hit each other, at a time in seconds of the pack (now, where it has passed). False if the table has nothing for them.
func hit(first: String, second: String, energy: float, position: Vector3, at := 0.0) -> bool:
	var row: Variant = _nearest(position, func(pair): return _alike(pair, [first, second]))
	if row == null and _materials.has(first) and _materials.has(second):
		var wanted := [_materials[first], _materials[second]]
		row = _nearest(position, func(pair): return _alike([_materials[pair[0]], _materials[pair[1]]], wanted))
	if row == null:
		return false
	var full: float = row["full_energy"]
	_begin(row["felt"], at, minf(energy / full, 1.0) / minf(row["energy"] / full, 1.0))
	return true


## Play a source with triggers once. False if it was not heard in the bake.
func play(source: String, at := 0.0) -> bool:
	if not _shots.has(source):
		return false
	_begin(_shots[source], at, 1.0)
	return true


## Go on to a time in seconds. Returns the samples since the last call, by listener.
func advance(until: float) -> Dictionary:
	var count := maxi(_index(until) - _played, 0)
	var blocks := {}
	for listener in listeners:
		var block := PackedFloat32Array()
		block.resize(count)
		var track: PackedFloat32Array = _tracks[listener]
		for k in count:
			var sample := (_played + k) % _length if loops else _played + k
			block[k] = track[sample] if sample < track.size() else 0.0
		for sound in _sounds:
			var felt: PackedFloat32Array = sound["felt"].get(listener, PackedFloat32Array())
			var offset: int = _played - sound["first"]
			for k in range(maxi(-offset, 0), mini(count, felt.size() - offset)):
				block[k] += sound["factor"] * felt[offset + k]
		var recent: PackedFloat32Array = _recent[listener]
		for k in count:
			block[k] = clampf(block[k], -_ceilings[listener], _ceilings[listener])
			recent[(_played + k) % recent.size()] = block[k]
		_recent[listener] = recent
		blocks[listener] = block
	_played += count
	_sounds = _sounds.filter(func(sound): return _played < sound["first"] + sound["length"])
	return blocks


## The level of the last quarter second without its mean, in decibels of full scale; null for silence.
func level_of(listener: String) -> Variant:
	var energy := 0.0
	var mean := 0.0
	for sample in _recent[listener]:
		energy += sample * sample
		mean += sample
	var size: int = _recent[listener].size()
	var rest := energy - mean * mean / size
	if rest <= 1e-12 * energy:
		return null
	return 10.0 * log(rest / maxi(mini(_played, size), 1)) / log(10.0)


func _read(form: Dictionary) -> void:
	limits = form["limits"]
	sample_rate = form["sample_rate"]
	_length = form["samples"]
	_materials = form["materials"]
	_tracks = _samples(form["tracks"])
	for item in form["listeners"]:
		listeners.append(item["name"])
		_ceilings[item["name"]] = item["s_max"]
		var recent := PackedFloat32Array()
		recent.resize(roundi(0.25 * sample_rate))
		_recent[item["name"]] = recent
	for row in form["blows"]:
		var place: Array = row["position"]
		row["position"] = Vector3(place[0], place[1], place[2])
		row["felt"] = _samples(row["felt"])
		blows.append(row)
	one_shots = form["one_shots"]
	for row in one_shots:
		if not _shots.has(row["source"]):
			_shots[row["source"]] = _samples(row["felt"])


func _samples(form: Dictionary) -> Dictionary:
	var found := {}
	for listener in form:
		found[listener] = Marshalls.base64_to_raw(form[listener]).to_float32_array()
	return found


func _begin(felt: Dictionary, at: float, factor: float) -> void:
	var longest := 0
	for samples in felt.values():
		longest = maxi(longest, samples.size())
	_sounds.append({"first": maxi(_index(at), _played), "factor": factor, "felt": felt, "length": longest})


func _nearest(position: Vector3, fits: Callable) -> Variant:
	var best: Variant = null
	for row in blows:
		if fits.call(row["objects"]) and (best == null or row["position"].distance_to(position) < best["position"].distance_to(position)):
			best = row
	return best


## The first sample that is not before a time, a millionth of a sample of rounding forgiven.
func _index(at: float) -> int:
	return ceili(at * sample_rate - 1e-6)


func _alike(pair: Array, other: Array) -> bool:
	return pair == other or pair == [other[1], other[0]]
