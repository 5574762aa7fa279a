## What Export for an Engine wrote: plays the animation of the glTF file frame by frame, and prints the levels that a
## server gives for the listeners.
##     godot --path . sample/exported.tscn -- PATH/NAME FRAME_RATE ws://127.0.0.1:7710
extends Node3D

var _path := ""
var _rate := 24.0
var _frame := 0
var _last := 0
var _player: AnimationPlayer
@onready var _haptics := $HapticTracing


func _enter_tree() -> void:
	var arguments := OS.get_cmdline_user_args()
	if arguments.size() < 3 or not FileAccess.file_exists(arguments[0] + ".glb"):
		printerr("After --, give PATH/NAME of an exported .glb without its ending, the frame rate, and the server's address")
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
	$HapticTracing.url = arguments[2]
	$HapticTracing.scene_file = _path + ".json"


func _ready() -> void:
	_haptics.levels_changed.connect(_show)
	_haptics.failed.connect(_fail)


func _physics_process(_delta: float) -> void:
	var time := _frame / _rate
	if _player:
		_player.seek(time, true)
	_haptics.step(time)


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
