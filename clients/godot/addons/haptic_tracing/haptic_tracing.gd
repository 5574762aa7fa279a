## A client of [code]haptic-tracing serve[/code]: sends the poses of the nodes that have the names of the scene's objects, and tells what each
## listener feels.
extends Node

## The scene of the server, once it has answered: the names of objects, sources and listeners.
signal scene_received(objects: PackedStringArray, sources: PackedStringArray, listeners: PackedStringArray)
## After each step, by listener: {"level": dB or null, "margin": dB or null, "gains": {source: gain}}.
signal levels_changed(levels: Dictionary)
## Two objects have hit each other, with an energy in joules.
signal impact_felt(first: String, second: String, energy: float, time: float)
## The server refused a message, or the connection ended.
signal failed(where: String, message: String)

## The address that haptic-tracing serve prints.
@export var url := "ws://127.0.0.1:7710"
## The token that it prints, for its devices to play.
@export var token := ""
## A haptic scene to send, exported from Blender; without it the server's own is used.
@export_file("*.json") var scene_file := ""
## Nodes are looked for below this one, or below the whole scene, by the names of the objects.
@export var root: NodePath
## The listener whose level shakes the gamepad, "" for none.
@export var felt_by_gamepad := ""
## The gamepad that is shaken.
@export var gamepad := 0
## Whether a step is sent in every physics frame; otherwise where [method step] is called.
@export var automatic := true
## How long a server is waited for that does not answer yet, in seconds.
@export var patience := 20.0

## The levels of the last step.
var levels := {}

var _socket := WebSocketPeer.new()
var _nodes := {}
var _sent := {}
var _impacts := []
var _is_open := false
var _has_scene := false
var _is_waiting := false
var _time := 0.0


func _ready() -> void:
	_socket.inbound_buffer_size = 1 << 22
	_socket.outbound_buffer_size = 1 << 22
	var error := _socket.connect_to_url(url)
	if error != OK:
		failed.emit("", "%s: %s" % [url, error_string(error)])
		set_physics_process(false)


func _exit_tree() -> void:
	if felt_by_gamepad != "":
		Input.stop_joy_vibration(gamepad)
	_socket.close()


## Play the signal of a source with triggers once.
func play(source: String) -> void:
	_send({"type": "play", "source": source})


## Fall silent and forget contacts.
func stop() -> void:
	_sent.clear()
	_send({"type": "stop"})


## Add objects, sources or listeners, as in a scene file: {"object": {...}}.
func add(parts: Dictionary) -> void:
	_send(parts.merged({"type": "add"}))


## Remove by name: {"object": name}.
func remove(parts: Dictionary) -> void:
	_sent.erase(parts.get("object", ""))
	_send(parts.merged({"type": "remove"}))


func _physics_process(delta: float) -> void:
	_time += delta
	_socket.poll()
	match _socket.get_ready_state():
		WebSocketPeer.STATE_OPEN:
			if not _is_open:
				_is_open = true
				_greet()
			while _socket.get_available_packet_count() > 0:
				var packet := _socket.get_packet()
				if _socket.was_string_packet():
					_receive(JSON.parse_string(packet.get_string_from_utf8()))
			if automatic:
				step(_time)
		WebSocketPeer.STATE_CLOSED when not _is_open and _time < patience:
			_socket.connect_to_url(url)
		WebSocketPeer.STATE_CLOSED:
			set_physics_process(false)
			failed.emit("", "%s has closed the connection, or does not answer" % url)


func _greet() -> void:
	var hello := {"type": "hello", "version": 1, "up": "y", "handedness": "right"}
	if token != "":
		hello["token"] = token
	if scene_file != "":
		hello["scene"] = JSON.parse_string(FileAccess.get_file_as_string(scene_file))
	_send(hello)


## Send what has moved up to a time in seconds. False where nothing is sent, because an answer is awaited.
func step(time: float) -> bool:
	if not _has_scene or _is_waiting:
		return false
	var poses := {}
	for object_name in _nodes:
		var node: Node3D = _nodes[object_name]
		if not is_instance_valid(node):
			continue
		var place := node.global_position
		var turn := node.global_basis.get_rotation_quaternion()
		var pose := [place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z]
		if _sent.get(object_name) != pose:
			_sent[object_name] = pose
			poses[object_name] = pose
	_is_waiting = true
	_send({"type": "step", "time": time, "poses": poses})
	return true


func _receive(message: Dictionary) -> void:
	match message["type"]:
		"scene":
			_has_scene = true
			_find(message["objects"])
			scene_received.emit(
				PackedStringArray(message["objects"]), PackedStringArray(message["sources"]), PackedStringArray(message["listeners"])
			)
		"frame":
			_is_waiting = false
			levels = message["levels"]
			levels_changed.emit(levels)
			for found in message["impacts"]:
				impact_felt.emit(found["objects"][0], found["objects"][1], found["energy"], found["time"])
			_shake()
		"error":
			_is_waiting = false
			failed.emit(message["where"], message["message"])


func _find(objects: Array) -> void:
	var top := get_node_or_null(root) if root else get_tree().current_scene
	_nodes.clear()
	for object_name in objects:
		# Godot has no dots and colons in the names of nodes: its importers make underscores of them.
		var known: String = object_name.validate_node_name()
		var node := top if top.name == known else top.find_child(known, true, false)
		if node is Node3D:
			_nodes[object_name] = node


func _shake() -> void:
	if felt_by_gamepad == "" or not levels.has(felt_by_gamepad):
		return
	var level: Variant = levels[felt_by_gamepad]["level"]
	# The peak amplitude of a tone of this level.
	var strength := 0.0 if level == null else minf(sqrt(2.0) * pow(10.0, float(level) / 20.0), 1.0)
	Input.start_joy_vibration(gamepad, strength, strength, 0.1)


func _send(message: Dictionary) -> void:
	if _socket.get_ready_state() == WebSocketPeer.STATE_OPEN:
		_socket.send_text(JSON.stringify(message, "", true, true))
