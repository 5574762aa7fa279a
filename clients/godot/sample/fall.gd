## A crate that Jolt drops onto the ground: prints the blow and the level at the hand, then ends after 3 seconds.
extends Node3D

var _blows := 0
var _seconds := 0.0
@onready var _crate: RigidBody3D = $Crate
@onready var _haptics := $HapticTracing


func _enter_tree() -> void:
	for argument in OS.get_cmdline_user_args():
		if argument.begins_with("ws://"):
			$HapticTracing.url = argument


func _ready() -> void:
	_crate.freeze = true
	# The server has loaded what it needs once it has answered a step.
	_haptics.levels_changed.connect(func(_levels): _crate.freeze = false, CONNECT_ONE_SHOT)
	_haptics.impact_felt.connect(_hit)
	_haptics.failed.connect(_fail)


func _hit(first: String, second: String, energy: float, time: float) -> void:
	_blows += 1
	print("%s and %s: %.1f J at %.2f s" % [first, second, energy, time])


func _fail(where: String, message: String) -> void:
	printerr("%s %s" % [where, message])
	get_tree().quit(1)


func _physics_process(delta: float) -> void:
	if _crate.freeze:
		return
	_seconds += delta
	if _seconds >= 3.0:
		print("%d blows, hand at %s dB" % [_blows, _haptics.levels["Hand"]["level"]])
		get_tree().quit(0 if _blows == 1 else 1)
