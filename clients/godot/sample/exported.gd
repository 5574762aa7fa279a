## What Export for an Engine wrote: plays the animation of the glTF file frame by frame, and prints the levels at the listeners: by a
## server where its address is given, otherwise by the baked pack.
##     godot --path . sample/exported.tscn -- PATH/NAME FRAME_RATE [ws://127.0.0.1:7710]
extends Node3D

const Pack := preload("res://addons/haptic_tracing/haptic_pack.gd")

var _path := ""
var _rate := 24.0
var _frame := 0
var _last := 0
var _player: AnimationPlayer
var _pack: Pack
@onready var _haptics := get_node_or_null("HapticTracing")


func _enter_tree() -> void:
	var arguments := OS.get_cmdline_user_args()
	if arguments.size() < 2 or not FileAccess.file_exists(arguments[0] + ".glb"):
		printerr("After --, give PATH/NAME of an exported .glb without its ending, the frame rate, and the server's address or nothing")
		_give_up()
		return
	_path = arguments[0]
	_rate = float(arguments[1])
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	document.append_from_file(_path + ".glb", state)
	var world := document.generate_scene(state, _rate)
	add_child(world)
	_player = world.find_child("AnimationPlayer")
	if _player:
		_player.play(_player.get_animation_list()[0])
		_last = roundi(_player.current_animation_length * _rate)
	if arguments.size() > 2:
		$HapticTracing.url = arguments[2]
		$HapticTracing.scene_file = _path + ".json"
	else:
		$HapticTracing.free()
		_pack = Pack.open(_path + ".pack.json")
		if _pack == null:
			_give_up()


func _ready() -> void:
	if _pack:
		for limit in _pack.limits:
			print("limit: ", limit)
	elif _haptics:
		_haptics.levels_changed.connect(_show)
		_haptics.failed.connect(_fail)


func _physics_process(_delta: float) -> void:
	var time := _frame / _rate
	if _player:
		_player.seek(time, true)
	if _haptics:
		_haptics.step(time)
		return
	# Here a game would call hit from its physics, and play from its rules.
	var before := (_frame - 1) / _rate
	for blow in _pack.blows:
		if blow["time"] >= before and blow["time"] < time:
			_pack.hit(blow["objects"][0], blow["objects"][1], blow["energy"], blow["position"], blow["time"])
	for shot in _pack.one_shots:
		if shot["time"] >= before and shot["time"] < time:
			_pack.play(shot["source"], shot["time"])
	_pack.advance(time)
	var levels := {}
	for listener in _pack.listeners:
		levels[listener] = {"level": _pack.level_of(listener)}
	_show(levels)


func _show(levels: Dictionary) -> void:
	var line := {}
	for listener in levels:
		line[listener] = levels[listener]["level"]
	print("levels: ", JSON.stringify(line))
	_frame += 1
	if _frame > _last:
		get_tree().quit()


func _fail(where: String, message: String) -> void:
	printerr("%s %s" % [where, message])
	get_tree().quit(1)


func _give_up() -> void:
	process_mode = PROCESS_MODE_DISABLED
	get_tree().quit(1)
